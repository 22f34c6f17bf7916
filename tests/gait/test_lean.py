"""Leaning into a force that lasts: the gait of a pendulum that is pulled is that of a free one."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_linefoot.constants import STANDARD_GRAVITY
from drake_linefoot.gait.measurement import lean_into
from drake_linefoot.statuses import Mode
from tests.helpers.pendulum_robot import PendulumRobot, landed
from tests.helpers.phases import mode_of

C = PendulumRobot().constants
forces = st.tuples(st.floats(-40.0, 40.0), st.floats(-40.0, 40.0)).map(np.array)
WALK = [0.4, 0.1, 0.3, 1.0]


@given(forces, st.floats(0.0, 1.2), st.floats(20.0, 90.0))
def test_a_robot_that_leans_is_in_balance_over_the_middle_of_its_feet(force, height, mass):
    """Moments about the ground of weight and force, at any height."""
    moment = np.cross([0.0, 0.0, height - C.com_height], [*force, 0.0])
    lean = lean_into(np.array([*moment, *force, 0.0]), mass, C)
    needed = np.linalg.norm(force) * height / (mass * STANDARD_GRAVITY)
    if needed < C.lean_max:
        com = np.array([*-lean, C.com_height])  # of feet in the origin
        weight = np.array([0.0, 0.0, -mass * STANDARD_GRAVITY])
        about = np.cross(com, weight) + np.cross([*com[:2], height], [*force, 0.0])
        np.testing.assert_allclose(about[:2], 0.0, atol=1e-9)
    assert np.linalg.norm(lean) == pytest.approx(min(needed, C.lean_max), abs=1e-12)


def test_nothing_that_pulls_asks_for_no_lean():
    np.testing.assert_array_equal(lean_into(np.zeros(6), 30.0, C), 0.0)
    turned = lean_into(np.array([0.0, 0.0, 5.0, 0.0, 0.0, -50.0]), 30.0, C)
    np.testing.assert_array_equal(turned, 0.0)


def pulled(force, known=True):
    """A pendulum of 1 kg that leans into a force [N], as it stands in balance."""
    robot = PendulumRobot()
    robot.force = np.array(force)
    if known:
        robot.external[3:5] = force
        robot.com[:2] -= robot.force / robot.constants.omega**2
    return robot


@pytest.mark.parametrize("force", [(-1.2, 0.0), (0.0, 0.6), (0.8, -0.9)])
def test_a_pendulum_that_is_pulled_walks_as_a_free_one_does(force):
    """All but its CoM, which is where the force asks for, is the same."""
    still, one = PendulumRobot(), pulled(force)
    for _ in range(3000):
        still.tick(WALK, landed(still.state))
        one.tick(WALK, landed(one.state))
        np.testing.assert_allclose(one.feet, still.feet, atol=2e-6)
    assert one.state.clock.steps == still.state.clock.steps > 8
    lean = np.array(force) / C.omega**2
    np.testing.assert_allclose(one.com[:2] + lean, still.com[:2], atol=2e-6)
    np.testing.assert_allclose(one.state.robot.lean, lean, atol=1e-12)


def test_a_pendulum_that_does_not_lean_is_carried_away():
    known, unknown = pulled((0.0, 1.5)), pulled((0.0, 1.5), known=False)
    for robot in (known, unknown):
        robot.run(np.zeros(4), 3.0)
    assert known.state.clock.steps == 0
    assert mode_of(known.state) == Mode.STAND
    assert unknown.state.clock.steps > 3
