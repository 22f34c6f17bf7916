"""A run: its pendulum against integration, its footholds against steps that are gone through."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from drake_linefoot.gait.command import choose_gait
from drake_linefoot.gait.constants import gait_constants, run_speed_max
from drake_linefoot.gait.known_ground import is_near_patch
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.gait.running import (
    after_bounce,
    after_flight,
    bounce,
    bounce_cop,
    com_at_landing,
    run_foothold,
    too_near,
)
from drake_linefoot.math.splines import quintic
from tests.helpers.pendulum_robot import ACCELERATION, ANKLES, LIMITS, PendulumRobot

G, FLIGHT = 9.81, 0.06
TIGHT = {"rtol": 1e-11, "atol": 1e-13}
P = GaitParameters()
STANCE = P.run_step - FLIGHT


@pytest.fixture(scope="module")
def robot():
    return PendulumRobot()


def running(robot, flight=FLIGHT, velocity=(0.0, 0.0), turn_rate=0.0):
    """A state of a run at a command that it has reached, and the constants."""
    s = robot.state.copy()
    s.command.flight = flight
    s.command.velocity[:], s.command.turn_rate, s.command.yaw = velocity, turn_rate, 0.0
    s.speed.scale[:], s.speed.offset[:] = 1.0, 0.0
    return s, robot.constants


heights, rates = st.floats(0.5, 0.7), st.floats(-0.6, 0.4)
durations, flights = st.floats(0.01, 0.15), st.floats(0.0, 0.08)


@given(heights, rates, durations, flights)
def test_a_flight_ends_as_high_as_it_began(z, rate, duration, flight):
    """Whatever the stance before it: the CoM leaves the ground with half of its fall ahead."""
    com, c = np.array([[0.0, 0.0, z], [1.0, 0.1, rate]]), PendulumRobot().constants
    cubic, omega = bounce(com, duration, flight, c)
    leaves = after_bounce(com, np.zeros(2), duration, cubic, omega)
    lands = after_flight(leaves, flight)
    assert leaves[1, 2] == pytest.approx(0.5 * G * flight, abs=1e-9)
    assert lands[0, 2] == pytest.approx(leaves[0, 2], abs=1e-9)
    assert lands[1, 2] == pytest.approx(-leaves[1, 2], abs=1e-9)


@given(heights, rates, durations)
def test_a_stance_takes_the_com_towards_its_height(z, rate, duration):
    """Between where a constant force takes it and the height that is asked for."""
    com, c = np.array([[0.0, 0.0, z], [0.0, 0.0, rate]]), PendulumRobot().constants
    cubic, omega = bounce(com, duration, FLIGHT, c)
    end = after_bounce(com, np.zeros(2), duration, cubic, omega)[0, 2]
    free = z + 0.5 * (rate + 0.5 * G * FLIGHT) * duration
    assert min(free, P.run_height) - 1e-9 <= end <= max(free, P.run_height) + 1e-9


@given(heights, rates, durations, st.floats(-0.2, 0.2), st.floats(-2.5, 2.5))
def test_a_bounce_is_a_pendulum_under_the_mean_force(z, rate, duration, place, speed):
    """``c'' = f_z / (m z) (c - p)`` with the mean of the force that the cubic asks for."""
    com, c = np.array([[0.1, -0.1, z], [speed, 0.2, rate]]), PendulumRobot().constants
    cop = np.array([place, 0.05])
    cubic, omega = bounce(com, duration, FLIGHT, c)
    out = after_bounce(com, cop, duration, cubic, omega)
    stiffness = min(max(G + (out[1, 2] - rate) / duration, 0.5 * G), 4.0 * G) / z

    def motion(t, y):
        return np.concatenate([y[2:], stiffness * (y[:2] - cop)])

    start = np.concatenate([com[0, :2], com[1, :2]])
    end = solve_ivp(motion, (0.0, duration), start, **TIGHT).y[:, -1]
    np.testing.assert_allclose(out[:, :2].ravel(), end, atol=1e-8)


def strides(s, c, count, com):
    """Steps of a run from a landing on the left foot: footholds, and the CoM at each landing."""
    feet, landings, foot, flight = [], [com], 0, s.command.flight
    for _ in range(count):
        heading, place = run_foothold(s, com, 0.0, foot, c)
        feet.append(place)
        cubic, omega = bounce(com, c.run_step - flight, flight, c)
        cop = bounce_cop(np.array([*place, 0.0, heading]), c)
        com = after_flight(after_bounce(com, cop, c.run_step - flight, cubic, omega), flight)
        landings.append(com)
        foot = 1 - foot
    return np.array(feet), np.array(landings)


@pytest.mark.parametrize("flight", [0.03, 0.06])
@pytest.mark.parametrize("velocity", [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (-1.0, 0.0), (1.5, 0.3)])
def test_steps_run_as_fast_and_as_wide_as_commanded(robot, flight, velocity):
    s, c = running(robot, flight, velocity)
    com = np.array([[0.0, 0.0, P.run_height], [velocity[0] + 0.1, velocity[1], -0.5 * G * flight]])
    feet, landings = strides(s, c, 12, com)
    np.testing.assert_allclose(landings[-2:, 1, :2].mean(axis=0), velocity, atol=1e-9)
    travelled = (landings[-1, 0, :2] - landings[-3, 0, :2]) / (2.0 * c.run_step)
    np.testing.assert_allclose(travelled, velocity, rtol=0.04, atol=1e-9)  # slower over a foot
    apart = feet[-2] - 0.5 * (feet[-1] + feet[-3])  # of a left foot from right ones
    assert apart[1] == pytest.approx(P.run_width, abs=1e-3)
    assert landings[-1, 0, 2] == pytest.approx(P.run_height, abs=2e-3)


def test_a_step_takes_all_of_an_error_of_the_speed(robot):
    """But for the bound that a leg stays no farther behind than it reaches."""
    s, c = running(robot, velocity=(1.0, 0.0))
    for error in (-0.1, 0.1):
        com = np.array([[0.0, 0.0, P.run_height], [1.0 + error, 0.0, -0.5 * G * FLIGHT]])
        assert strides(s, c, 1, com)[1][-1, 1, 0] == pytest.approx(1.0, abs=1e-9)
    com = np.array([[0.0, 0.0, P.run_height], [1.0, 0.0, -0.5 * G * FLIGHT]])
    s.command.velocity[0] = 2.0
    feet, landings = strides(s, c, 1, com)
    assert landings[-1, 1, 0] < 1.9
    assert STANCE * 1.0 - (feet[0, 0] - com[0, 0]) == pytest.approx(P.run_trail)


@given(st.floats(-2.0, 2.5), st.floats(-0.3, 0.3), st.floats(-1.0, 1.0), st.floats(-0.2, 0.2))
def test_footholds_are_mirrored_with_the_run(forward, left, turn, aside):
    robot = PendulumRobot()
    s, c = running(robot, velocity=(forward, left), turn_rate=turn)
    com = np.array([[0.1, aside, 0.61], [forward, left + aside, -0.3]])
    heading, place = run_foothold(s, com, 0.05, 0, c)
    s, c = running(robot, velocity=(forward, -left), turn_rate=-turn)
    flipped = com * [1.0, -1.0, 1.0]
    mirrored, other = run_foothold(s, flipped, 0.05, 1, c)
    assert mirrored == pytest.approx(-heading, abs=1e-12)
    np.testing.assert_allclose(other, place * [1.0, -1.0], atol=1e-12)


@pytest.mark.parametrize("foot", [0, 1])
@pytest.mark.parametrize("lands", ["alone", "first", "second"])
@pytest.mark.parametrize("heading", [0.0, 0.7])
def test_a_foot_lands_clear_of_the_other_leg(robot, foot, lands, heading):
    """Of where that stands, or has stood until now, or will land before it."""
    s, c = running(robot, velocity=(1.0, 0.0))
    other, now = 1 - foot, s.clock.time
    stood, goes_to = np.array([0.2, 0.1]), np.array([0.5, -0.3])
    s.robot.feet[other, :2], s.swing.target[other, :2] = stood, goes_to
    s.clock.lift_off[other] = now + 0.05 if lands == "alone" else now - 0.01
    s.clock.touchdown[foot] = now + 0.05
    s.clock.touchdown[other] = now + {"alone": -0.1, "first": 0.2, "second": 0.02}[lands]
    outward = np.array([-np.sin(heading), np.cos(heading)]) * (1.0, -1.0)[foot]
    leg = goes_to if lands == "second" else stood
    for beside, moved in ((0.02, 0.065), (0.2, 0.0)):
        place = leg + beside * outward + 0.3 * np.array([np.cos(heading), np.sin(heading)])
        assert too_near(s, foot, place, heading, c) == pytest.approx(moved, abs=1e-9)


def test_the_landing_is_foreseen_through_flight_and_stance(robot):
    """Both feet in the air: the other one lands first, at its target, and bears in between."""
    s, c = running(robot, velocity=(1.0, 0.0))
    now = s.clock.time
    s.robot.pendulum_com[:], s.robot.com_velocity[:] = (0.0, 0.0, 0.64), (1.0, 0.05, 0.1)
    s.robot.feet[:, 2] = 0.0
    s.swing.target[0] = np.array([0.1, 0.06, 0.0, 0.0, 0.0])
    s.clock.lift_off[:] = now - 0.05, now - 0.01
    s.clock.touchdown[:] = now + 0.03, now + 0.03 + c.run_step
    s.clock.side = 0
    com = after_flight(np.array([[0.0, 0.0, 0.64], [1.0, 0.05, 0.1]]), 0.03)
    np.testing.assert_allclose(com_at_landing(s, 0, c), com, atol=1e-12)
    cubic, omega = bounce(com, STANCE, FLIGHT, c)
    cop = bounce_cop(np.array([0.1, 0.06, 0.0, 0.0]), c)
    com = after_flight(after_bounce(com, cop, STANCE, cubic, omega), FLIGHT)
    np.testing.assert_allclose(com_at_landing(s, 1, c), com, atol=1e-9)


def chosen(robot, speed, runs, *, walk=True, flight=-1.0):
    """T_f of the steps that follow a touchdown [s]."""
    s, c = running(robot, FLIGHT if runs else 0.0, (speed, 0.0))
    c = c.copy()
    c.flight = flight
    choose_gait(s, walk, c)
    return s.command.flight


def test_the_speed_chooses_with_hysteresis(robot):
    between = 0.5 * (P.walk_below + P.run_above)
    assert P.walk_below < P.run_above
    assert chosen(robot, 1.01 * P.run_above, False) == P.run_flight
    assert chosen(robot, -1.01 * P.run_above, False) == P.run_flight
    assert chosen(robot, between, False) == 0.0
    assert chosen(robot, between, True) > 0.0
    assert chosen(robot, 0.99 * P.walk_below, True) == 0.0


@pytest.mark.parametrize("flight", [None, 0.04])
def test_a_robot_runs_as_fast_as_its_legs_swing(flight):
    """A foot goes two steps far, from rest to rest, with a share of what the leg can."""
    p = replace(P, flight=flight)
    length = 2.0 * p.run_step * run_speed_max(p, ACCELERATION)
    duration = p.run_step + (flight or p.run_flight)
    end = np.array([[length], [0.0], [0.0]])
    motion = quintic(np.zeros((3, 1)), end, duration, np.linspace(0.0, duration, 1001))
    share = np.abs(motion[2]).max() / ACCELERATION[0]
    assert share == pytest.approx(0.6, abs=1e-4)


def test_a_robot_whose_legs_are_too_slow_to_run_walks():
    def with_share(share):
        about = LIMITS, (0.075, 0.0, 0.0), share * ACCELERATION, ANKLES
        c = gait_constants(P, *about)[0]
        return c.run_above, c.command_max[0]

    assert with_share(1.0) == (P.run_above, P.forward_max)
    assert with_share(0.2) == (math.inf, P.walk_max)
    share = 1.2 * P.run_above / run_speed_max(P, ACCELERATION)
    assert with_share(share) == (P.run_above, pytest.approx(1.2 * P.run_above))


def test_a_flight_that_is_asked_for_is_run_at_any_speed(robot):
    assert chosen(robot, 0.0, False, flight=0.05) == 0.05
    assert chosen(robot, 2.0, False, flight=0.0) == 0.0
    assert chosen(robot, 0.0, True, flight=0.05, walk=False) == 0.0
    assert chosen(robot, 2.0, True, flight=0.05, walk=False) > 0.0
    assert math.isclose(P.run_step - P.run_flight, STANCE)


@pytest.mark.parametrize("patch_height", [0.0, -0.05])
def test_a_foot_at_the_apex_of_its_swing_has_not_landed(robot, patch_height):
    """In a run, where what the other foot takes from the ground looks like a force on it."""
    s, c = running(robot)
    s.swing.target[1, 2], s.swing.height[1] = patch_height, 0.1
    high, low = np.zeros(4), np.zeros(4)
    high[2], low[2] = patch_height + 0.09, patch_height + 0.03
    slow, fast = -2.0 * c.contact_speed, -20.0 * c.contact_speed
    assert not is_near_patch(s, 1, high, slow, c)
    assert is_near_patch(s, 1, low, slow, c)
    assert is_near_patch(s, 1, high, fast, c)  # stopped on its way down, by a high tile
    s.command.flight = 0.0
    assert is_near_patch(s, 1, high, slow, c)
