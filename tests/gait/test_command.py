"""How fast the gait walks: what ground allows that is not flat and firm."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_linefoot.gait.command import allowed_command, speed_limit
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.lab.simulation.channels import LIMITS
from drake_linefoot.statuses import Limit, Mode
from tests.helpers.pendulum_robot import DT, PendulumRobot, landed
from tests.helpers.phases import mode_of


@pytest.fixture(scope="module")
def constants():
    return PendulumRobot().constants


FLOORS = [(0.0, 0.0, 1.0), (0.0, 0.001, 0.8), (0.0, 0.0, 0.61), (0.049, 0.0005, 0.7)]


@pytest.mark.parametrize(("slope", "unevenness", "friction"), FLOORS)
def test_a_floor_is_walked_at_any_speed_that_may_be_commanded(
    constants, slope, unevenness, friction
):
    p = GaitParameters()
    limit, _ = speed_limit(slope, unevenness, friction, constants)
    assert limit >= np.hypot(p.forward_max, p.lateral_max)


def alone_and_milder(unevenness, friction, c):
    """How fast ground is walked that is uneven alone, and slippery alone, a tenth as much.

    So mild neither is walked at the least speed, at which one could not tell which is worse.
    """
    floor, firm = 0.2 * c.unevenness_max, c.friction_firm  # which change nothing
    milder = floor + 0.1 * (unevenness - floor), firm + 0.1 * (friction - firm)
    return speed_limit(0.0, milder[0], 1.0, c)[0], speed_limit(0.0, 0.0, milder[1], c)[0]


@given(st.floats(0.0, 0.4), st.floats(0.0, 0.05), st.floats(0.3, 1.0), st.floats(1.0, 3.0))
def test_rougher_ground_is_never_walked_faster(slope, unevenness, friction, more):
    c, p = PendulumRobot().constants, GaitParameters()
    limit, why = speed_limit(slope, unevenness, friction, c)
    assert 0.0 < limit <= np.hypot(p.forward_max, p.lateral_max)
    assert slope * limit <= p.climb_max * (1.0 + 1e-12)
    if unevenness >= p.unevenness_max or friction <= p.friction_careful:
        assert limit <= p.careful_speed
    if slope * limit < 0.99 * p.climb_max and limit < 0.99 * np.hypot(p.forward_max, p.lateral_max):
        firm, slippery = alone_and_milder(unevenness, friction, c)
        assert why == (Limit.SLIPPERY if firm > slippery else Limit.UNEVEN)
    for rougher in [(more * slope, unevenness, friction), (slope, more * unevenness, friction)]:
        assert speed_limit(*rougher, c)[0] <= limit
    assert speed_limit(slope, unevenness, friction / more, c)[0] <= limit


@pytest.mark.parametrize(
    ("command", "state", "why"),
    [
        ([0.9, 0.0, 0.0, 1.0], {}, Limit.FREE),
        ([9.0, 0.0, 0.0, 1.0], {}, Limit.CLIPPED),
        ([0.9, 0.0, -9.0, 1.0], {}, Limit.CLIPPED),
        ([0.9, 0.0, 0.0, 1.0], {("ground", "slope"): [0.3, 0.0]}, Limit.SLOPED),
        ([0.9, 0.0, 0.0, 1.0], {("ground", "unevenness"): 0.1}, Limit.UNEVEN),
        ([0.9, 0.0, 0.0, 1.0], {("footing", "friction"): 0.4}, Limit.SLIPPERY),
        ([9.0, 0.0, 0.0, 1.0], {("footing", "friction"): 0.4}, Limit.SLIPPERY),
        ([0.1, 0.0, 0.0, 1.0], {("footing", "friction"): 0.4}, Limit.FREE),
    ],
)
def test_it_says_why_it_follows_another_command_than_it_was_given(command, state, why):
    robot = PendulumRobot()
    for (part, name), value in state.items():
        robot.state[part][name] = value
    robot.tick(command)
    assert robot.state.command.limited == why
    assert robot.state.command.clipped == (why != Limit.FREE)
    assert LIMITS[int(why)] or why == Limit.FREE
    assert len(LIMITS) == len(Limit)


@pytest.mark.parametrize(("flight", "why"), [(0.0, Limit.UNEVEN), (0.06, Limit.FREE)])
def test_a_run_goes_over_tiles(flight, why):
    robot = PendulumRobot()
    robot.state.ground.unevenness, robot.state.command.flight = 0.1, flight
    assert allowed_command(robot.state, np.array([1.5, 0.0, 0.0, 1.0]), robot.constants)[1] == why


@pytest.mark.parametrize(
    ("flight", "unevenness", "why"),
    [(0.0, 0.0, Limit.SLOPED), (0.06, 0.0, Limit.SLOPED), (0.06, 0.02, Limit.FREE)],
)
def test_what_tiles_raise_between_two_feet_slows_no_run_down(flight, unevenness, why):
    robot = PendulumRobot()
    s = robot.state
    s.ground.slope[0], s.ground.unevenness, s.command.flight = 0.1, unevenness, flight
    assert allowed_command(s, np.array([1.5, 0.0, 0.0, 1.0]), robot.constants)[1] == why


def test_a_foot_that_slides_makes_the_walk_slower_for_a_while():
    """Aside at 0.3 m/s against a force of 0.4 of the load, as on ice; then it stands again."""
    p, robot = GaitParameters(), PendulumRobot()
    command = [0.9, 0.0, 0.0, 1.0]
    robot.run(command, 3.0)
    assert robot.state.footing.friction == 1.0
    assert robot.state.command.velocity[0] == pytest.approx(0.9)
    for _ in range(3):
        while mode_of(robot.state) != Mode.SWING:
            robot.tick(command, landed(robot.state))
        side, still = int(robot.state.clock.side), robot.dynamics
        robot.feet[side, 1] += 0.02
        robot.wrench[side] = [0.0, -40.0, 100.0, 0.0, 0.0]
        robot.dynamics = lambda d=still: d()._replace(v_WC=np.tile([0.0, 0.3, 0.0], (2, 1)))
        while mode_of(robot.state) == Mode.SWING:
            robot.tick(command, landed(robot.state))
        robot.dynamics, robot.wrench[:] = still, 0.0
    assert robot.state.footing.friction < 0.45
    after = [t.state for t in robot.run(command, 20.0)]
    slowest = min(after, key=lambda s: s.command.velocity[0])
    assert slowest.command.velocity[0] < 0.9 - p.linear_acceleration * p.single_support
    assert slowest.command.limited == Limit.SLIPPERY
    assert after[-1].command.velocity[0] == pytest.approx(0.9)


def test_a_foot_that_creeps_changes_nothing():
    """However far: the ground gives it the force that is asked for."""
    robot, command = PendulumRobot(), [0.9, 0.0, 0.0, 1.0]
    robot.run(command, 3.0)
    still = robot.dynamics
    robot.wrench[:] = [0.0, -20.0, 100.0, 0.0, 0.0]
    robot.dynamics = lambda: still()._replace(v_WC=np.tile([0.0, 0.05, 0.0], (2, 1)))
    for _ in range(2000):
        if mode_of(robot.state) == Mode.SWING:
            robot.feet[int(robot.state.clock.side), 1] += 0.05 * DT
        robot.tick(command, landed(robot.state))
        assert robot.state.footing.friction == 1.0
        assert robot.state.command.limited == Limit.FREE
    assert robot.state.command.velocity[0] == pytest.approx(0.9)
