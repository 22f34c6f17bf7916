"""Footholds that the leg can reach from the CoM, and steps that are made sooner for that."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from drake_linefoot.gait.footsteps import StepCommand, clip_foothold, heading_vector
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.gait.pendulum import dcm, propagate_com, propagate_dcm
from drake_linefoot.gait.state import Mode
from drake_linefoot.gait.touchdown import aim, swing_target
from tests.helpers.pendulum_robot import DT, PendulumRobot
from tests.helpers.steps import (
    OMEGA,
    ONE,
    SHAPE,
    UNLIMITED,
    ZERO,
    T,
    angles,
    cases,
    commands,
    constants,
    points,
    sides,
    swing_state,
)

FLIP = np.array([1.0, -1.0])
DECREMENT, SETTLE = 0.01, 0.03
REACH = SHAPE.reach_limits


# --- reach ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("foothold", "side", "expected"),
    [
        ([0.30, 0.10], 0, [0.22, 0.10]),  # too far ahead
        ([-0.30, 0.10], 0, [-0.22, 0.10]),  # and behind
        ([0.10, 0.35], 0, [0.10, 0.28]),  # too far to the left of a left foot
        ([0.10, 0.35], 1, [0.10, 0.35]),  # a right foot that crosses is for others to stop
        ([0.10, -0.35], 1, [0.10, -0.28]),
        ([0.40, -0.35], 1, [0.22, -0.28]),
        ([0.21, 0.27], 0, [0.21, 0.27]),
    ],
)
@pytest.mark.parametrize("yaw", [0.0, 0.7, -2.5])
def test_a_foothold_is_moved_to_where_the_leg_reaches(foothold, side, expected, yaw):
    com = np.array([1.3, -0.4])
    place, moved = clip_foothold(com + heading_vector(yaw, *foothold), com, yaw, side, REACH)
    np.testing.assert_allclose(place, com + heading_vector(yaw, *expected), atol=1e-15)
    assert moved == (foothold != expected)


@given(points, points, angles, sides)
def test_a_mirrored_foothold_is_moved_to_the_mirrored_place(foothold, com, yaw, side):
    place, moved = clip_foothold(foothold, com, yaw, side, REACH)
    other, other_moved = clip_foothold(foothold * FLIP, com * FLIP, -yaw, 1 - side, REACH)
    np.testing.assert_allclose(other, place * FLIP, atol=1e-12)
    assert other_moved == moved


@given(points, points, angles, sides, points, angles)
def test_reach_does_not_depend_on_where_the_world_begins(foothold, com, yaw, side, shift, turn):
    def move(p):
        return shift + heading_vector(turn, *p)

    place, _ = clip_foothold(foothold, com, yaw, side, REACH)
    other, _ = clip_foothold(move(foothold), move(com), yaw + turn, side, REACH)
    np.testing.assert_allclose(other, move(place), atol=1e-12)


@given(points, points, points, st.floats(0.0, 0.3))
def test_the_com_at_touchdown_is_that_of_a_falling_pendulum(com, velocity, cop, duration):
    fallen = solve_ivp(
        lambda t, y: [*y[2:], *OMEGA**2 * (y[:2] - cop)],
        (0.0, duration), [*com, *velocity], rtol=1e-11, atol=1e-12,
    ).y[:, -1]  # fmt: skip
    place = propagate_com(np.array([*com, 0.6]), np.array([*velocity, 0.3]), cop, OMEGA, duration)
    np.testing.assert_allclose(place, fallen[:2], atol=1e-8)
    # Its velocity makes it the DCM that is known in closed form.
    xi = propagate_dcm(dcm(com, velocity, OMEGA), cop, OMEGA, duration)
    np.testing.assert_allclose(place, xi - fallen[2:] / OMEGA, atol=1e-8)


@given(points, points, points, angles, sides, commands, st.floats(0.0, 0.2))
def test_every_target_is_within_reach(com, velocity, stance, yaw, side, command, remaining):
    case = (com, velocity, stance, yaw, side, command)
    target, _ = swing_target(swing_state(case), remaining, SHAPE)
    landing = propagate_com(com, velocity, stance, OMEGA, remaining)
    heading = yaw + command.turn_rate * (remaining + 0.5 * T)
    forward, left = heading_vector(-heading, *(target[:2] - landing))
    assert abs(forward) <= REACH[0] + 1e-9
    assert (left if side == 0 else -left) <= REACH[2] + 1e-9


# --- step time ------------------------------------------------------------------------------


def aimed(state, remaining, shortest, decrement, acceleration=np.inf):
    """Call `aim` for a state whose foot is to land in `remaining`, but not before `shortest`."""
    state.phase_end = state.due = remaining
    aim(
        state,
        constants(
            SHAPE,
            step_time_decrement=decrement, remaining_time_min=shortest, swing_time_min=0.0,
            swing_acceleration_max=acceleration, settle_time=SETTLE,
        ),
    )  # fmt: skip
    assert state.due == state.phase_end
    return state.target, bool(state.moved_footholds), state.phase_end


def timed(case, remaining, shortest, decrement, acceleration=np.inf):
    """Call `aim` for a swing foot that is at rest in the origin."""
    return aimed(swing_state(case), remaining, shortest, decrement, acceleration)


@given(cases, st.floats(0.0, 0.2), st.floats(0.0, 0.2))
def test_without_a_decrement_it_is_the_target_of_the_planned_time(case, remaining, shortest):
    target, moved, when = timed(case, remaining, shortest, 0.0)
    expected, expected_moved = swing_target(swing_state(case), remaining, SHAPE)
    np.testing.assert_array_equal(target, expected)
    assert (moved, when) == (expected_moved, remaining)


@given(cases, st.floats(0.0, 0.2), st.floats(0.0, 0.2))
def test_a_step_is_sooner_by_no_more_than_it_takes(case, remaining, shortest):
    """Every sooner time that was passed over is out of reach, the chosen one is in it or last."""
    target, moved, when = timed(case, remaining, shortest, DECREMENT)
    expected, expected_moved = swing_target(swing_state(case), when, SHAPE)
    np.testing.assert_array_equal(target, expected)
    assert moved == expected_moved
    decrements = round((remaining - when) / DECREMENT)
    assert when == pytest.approx(remaining - decrements * DECREMENT, abs=1e-12)
    assert when >= min(shortest, remaining)
    for k in range(decrements):
        assert swing_target(swing_state(case), remaining - k * DECREMENT, SHAPE)[1]
    if moved:
        assert when - DECREMENT < shortest + 1e-12


@given(cases, st.floats(0.12, 0.2), st.floats(50.0, 400.0))
def test_the_foot_of_a_shortened_step_is_not_driven_faster_than_it_can_be(case, remaining, limit):
    """A rest-to-rest quintic of length d and time t peaks at 10 d / (sqrt(3) t^2)."""
    target, _, when = timed(case, remaining, 0.08, DECREMENT, limit)
    peak = 10.0 / np.sqrt(3.0) * np.hypot(*target[:2]) / (when - SETTLE) ** 2
    assert when == remaining or peak <= 1.001 * limit
    *_, soonest = timed(case, remaining, 0.08, DECREMENT)
    assert when >= soonest
    if when > soonest:  # one decrement more would be too much
        sooner, _ = swing_target(swing_state(case), when - DECREMENT, SHAPE)
        peak = 10.0 / np.sqrt(3.0) * np.hypot(*sooner[:2]) / (when - DECREMENT - SETTLE) ** 2
        assert peak > 0.999 * limit


@given(st.floats(-0.2, 0.2), angles, sides, st.floats(-0.2, 0.2))
def test_a_foothold_in_reach_keeps_its_step_time(forward, yaw, side, speed):
    """A CoM that is 0.08 m beside its stance foot, at rest to the side, and falls with it."""
    stance = heading_vector(yaw, 0.0, (-0.08, 0.08)[side])
    com, velocity = np.zeros(2), heading_vector(yaw, speed, 0.0)
    case = (com, velocity, stance, yaw, side, StepCommand(np.array([forward, 0.0]), 0.0, T))
    assert not swing_target(swing_state(case), 0.1, SHAPE)[1]
    _, moved, when = timed(case, 0.1, 0.0, DECREMENT)
    assert (moved, when) == (False, 0.1)


@pytest.mark.parametrize("direction", np.arange(8) * 0.25 * np.pi)
@pytest.mark.parametrize("side", [0, 1])
def test_a_shorter_step_brings_the_foot_nearer_to_where_the_pendulum_needs_it(side, direction):
    """A robot that steps in place and is pushed by 0.8 m/s, just after lift-off."""
    stance = np.array([0.0, (-0.08, 0.08)[side]])
    velocity = heading_vector(direction, 0.8, 0.0)

    def miss(decrement):
        command = StepCommand(ZERO, 0.0, T)
        state = swing_state((ZERO, velocity, stance, 0.0, side, command), 0.0, ZERO, ONE, ZERO)
        target, moved, when = aimed(state.copy(), 0.19, 0.08, decrement)
        desired, _ = swing_target(state, when, UNLIMITED)
        assert moved or np.array_equal(target, desired)
        return np.linalg.norm(target - desired), when

    (planned, full), (shortened, when) = miss(0.0), miss(DECREMENT)
    assert full == 0.19
    assert planned > 0.0
    assert 0.08 <= when < full
    assert shortened < 0.8 * planned


# --- in the gait ------------------------------------------------------------------------


def pushed_swing(push, **parameters):
    """The states of the swing in which a pendulum robot is pushed, 20 ms after lift-off."""
    robot = PendulumRobot(GaitParameters(**parameters))
    robot.run([0.3, 0.0, 0.0, 1.0], 0.91)
    while robot.state.mode != Mode.SWING or robot.state.time - robot.state.phase_start < 0.0199:
        robot.run([0.3, 0.0, 0.0, 1.0], DT)
    robot.com_velocity[:2] += push
    states, steps = [robot.state], robot.state.steps
    while robot.state.steps == steps:
        states += [t.state for t in robot.run([0.3, 0.0, 0.0, 1.0], DT)]
    return states


@pytest.mark.parametrize("push", [[0.6, 0.0], [-0.8, 0.0], [0.0, 0.6], [0.0, -0.6]])
@pytest.mark.parametrize(("flight", "swing"), [(0.08, 0.10), (0.12, 0.10), (0.08, 0.16)])
def test_a_pushed_robot_steps_sooner_but_not_below_the_bounds(push, flight, swing):
    states = pushed_swing(push, remaining_time_min=flight, swing_time_min=swing)
    start = states[0].phase_start
    length = states[-1].time - start
    assert swing - 1e-9 <= length < 0.2 - 1e-9
    assert length == pytest.approx(states[-2].due - start, abs=1e-9)
    for a, b in pairwise(states[:-1]):
        assert b.due == b.phase_end <= a.due
        if b.due < a.due:
            assert b.due - b.time >= flight - 1e-9


def test_a_robot_with_a_fixed_step_time_steps_when_planned():
    states = pushed_swing([0.6, 0.0], step_time_decrement=0.0)
    assert states[-1].time - states[0].phase_start == pytest.approx(0.2, abs=1e-9)


def test_a_robot_that_is_not_pushed_steps_when_planned():
    states = pushed_swing([0.0, 0.0])
    assert states[-1].time - states[0].phase_start == pytest.approx(0.2, abs=1e-9)
    assert states[-1].moved_footholds == 0
