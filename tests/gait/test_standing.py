"""Whether the DCM of a robot that stands is over its feet, against the hull by Qhull."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from drake_linefoot.gait.pendulum import dcm
from drake_linefoot.gait.standing import outside_feet
from tests.helpers.pendulum_robot import HALF_LENGTH, STAND_STILL, PendulumRobot
from tests.helpers.steps import constants

HALF_WIDTH, MARGIN = 0.03, 0.004


def robot_on(half_width):
    """A robot that stands, and its constants with feet of a width, of which a margin is left."""
    robot = PendulumRobot()
    state = robot.run(STAND_STILL, 0.01)[-1].state
    wide = {"half_width": half_width and half_width + MARGIN, "contact_margin": MARGIN}
    return state, constants(robot.constants, half_length=HALF_LENGTH + MARGIN, **wide)


def distance(corners, xi):
    """How far a place is outside a hull: beyond the line of the edge that it is farthest from."""
    hull = ConvexHull(corners)
    return max(0.0, float((hull.equations @ [*xi, 1.0]).max()))


@pytest.mark.parametrize("half_width", [0.0, HALF_WIDTH])
@given(st.integers(0, 2**32 - 1))
def test_the_hull_is_that_of_heels_and_toes_or_of_all_corners(half_width, seed):
    random, (state, c) = np.random.default_rng(seed), robot_on(half_width)
    s, corners = state.copy(), []
    for side in (0, 1):
        yaw = random.uniform(-0.5, 0.5)
        middle = np.array([random.uniform(-0.2, 0.2), (0.1, -0.1)[side]])
        s.robot.feet[side] = [*middle, 0.0, yaw]
        x, y = np.array([np.cos(yaw), np.sin(yaw)]), np.array([-np.sin(yaw), np.cos(yaw)])
        for a in (-HALF_LENGTH, HALF_LENGTH):
            corners += [middle + a * x + b * y for b in (-half_width, half_width)]
    s.robot.pendulum_com[:2] = random.uniform(-0.3, 0.3, 2)
    s.robot.pendulum_velocity[:2] = random.uniform(-0.3, 0.3, 2)
    xi = dcm(s.robot.pendulum_com, s.robot.pendulum_velocity, c.omega)
    found = outside_feet(s, c)
    assert found == pytest.approx(distance(np.unique(corners, axis=0), xi), abs=1e-9)


def test_a_sole_holds_what_a_line_does_not():
    """Beside the left foot, within its width."""
    for half_width, outside in ((0.0, 0.02), (HALF_WIDTH, 0.0)):
        state, c = robot_on(half_width)
        s = state.copy()
        s.robot.pendulum_com[:2] = s.robot.feet[0, :2] + [0.0, 0.02]
        s.robot.pendulum_velocity[:2] = 0.0
        assert outside_feet(s, c) == pytest.approx(outside, abs=1e-6)
