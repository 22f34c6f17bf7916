"""How fast the gait walks: what ground allows that is not flat and firm."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_linefoot.gait.command import speed_limit
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.gait.state import Mode
from tests.helpers.pendulum_robot import PendulumRobot


@pytest.fixture(scope="module")
def constants():
    return PendulumRobot().constants


FLOORS = [(0.0, 0.0, 0.0), (0.0, 0.001, 0.0), (0.0, 0.0, 0.0005), (0.05, 0.0005, 0.0005)]


@pytest.mark.parametrize(("slope", "unevenness", "slip"), FLOORS)
def test_a_floor_is_walked_at_any_speed_that_may_be_commanded(constants, slope, unevenness, slip):
    p = GaitParameters()
    limit = speed_limit(slope, unevenness, slip, constants)
    assert limit >= np.hypot(p.forward_max, p.lateral_max)


@given(st.floats(0.0, 0.4), st.floats(0.0, 0.05), st.floats(0.0, 0.5), st.floats(1.0, 3.0))
def test_rougher_ground_is_never_walked_faster(slope, unevenness, slip, more):
    c, p = PendulumRobot().constants, GaitParameters()
    limit = speed_limit(slope, unevenness, slip, c)
    assert 0.0 < limit <= np.hypot(p.forward_max, p.lateral_max)
    assert slope * limit <= p.climb_max * (1.0 + 1e-12)
    if unevenness >= p.unevenness_max or slip >= p.slip_max:
        assert limit <= p.careful_speed
    for rougher in [(more * slope, unevenness, slip), (slope, more * unevenness, slip)]:
        assert speed_limit(*rougher, c) <= limit
    assert speed_limit(slope, unevenness, more * slip, c) <= limit


def test_a_foot_that_slides_makes_the_walk_slower_for_a_while():
    p, robot = GaitParameters(), PendulumRobot()
    command = [0.9, 0.0, 0.0, 1.0]
    robot.run(command, 3.0)
    assert robot.state.slip == 0.0
    assert robot.state.velocity[0] == pytest.approx(0.9)
    while robot.state.mode != Mode.SWING:
        robot.tick(command)
    robot.feet[int(robot.state.side), 1] += 0.02
    after = [t.state for t in robot.run(command, 6.0)]
    slowest = min(after, key=lambda s: s.velocity[0])
    assert slowest.velocity[0] < 0.9 - p.linear_acceleration * p.single_support
    assert after[-1].velocity[0] == pytest.approx(0.9)
