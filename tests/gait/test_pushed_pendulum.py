"""A pendulum that is pushed while it walks or stands: when and where it steps."""

import numpy as np
import pytest

from drake_linefoot.gait.footsteps import heading_vector
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.statuses import Mode
from tests.helpers.pendulum_robot import DT, PendulumRobot
from tests.helpers.phases import mode_of, phase_end, phase_start, planned_touchdown


def pushed_swing(push):
    """The robot and the states of the swing in which it is pushed, 20 ms after lift-off."""
    robot = PendulumRobot(GaitParameters())
    robot.run([0.3, 0.0, 0.0, 1.0], 0.91)
    while (
        mode_of(robot.state) != Mode.SWING
        or robot.state.clock.time - phase_start(robot.state) < 0.0199
    ):
        robot.run([0.3, 0.0, 0.0, 1.0], DT)
    robot.com_velocity[:2] += push
    states, steps = [robot.state], robot.state.clock.steps
    while robot.state.clock.steps == steps:
        states += [t.state for t in robot.run([0.3, 0.0, 0.0, 1.0], DT)]
    return robot, states


@pytest.mark.parametrize("push", [[0.6, 0.0], [-0.8, 0.0], [0.0, 0.6], [0.0, -0.6]])
def test_a_pushed_robot_steps_sooner_but_not_sooner_than_its_leg_can(push):
    robot, states = pushed_swing(push)
    start = phase_start(states[0])
    length = states[-1].clock.time - start
    assert robot.constants.swing_time_min - DT <= length < 0.2 - 1e-9
    for state in states[:-1]:
        assert planned_touchdown(state) == phase_end(state)
        assert planned_touchdown(state) - start >= robot.constants.swing_time_min - 1e-9


def test_a_robot_that_is_not_pushed_steps_when_planned():
    _, states = pushed_swing([0.0, 0.0])
    assert states[-1].clock.time - phase_start(states[0]) == pytest.approx(0.2, abs=1e-9)
    assert states[-1].recovery.moved_footholds == 0


# --- from standing ----------------------------------------------------------------------


def stood(push):
    """A robot that stands, is pushed, and has stood or stepped for 1.5 s; its modes."""
    robot = PendulumRobot()
    robot.run([0.0] * 4, 0.1)
    robot.com_velocity[:2] += push
    return robot, {mode_of(t.state) for t in robot.run([0.0] * 4, 1.5)}


@pytest.mark.parametrize("push", [[0.25, 0.0], [-0.25, 0.0], [0.0, 0.28], [0.1, -0.2]])
def test_a_standing_robot_holds_a_small_push_without_a_step(push):
    robot, modes = stood(push)
    assert modes == {Mode.STAND}
    np.testing.assert_allclose(robot.com[:2], 0.0, atol=0.01)


@pytest.mark.parametrize("direction", np.arange(8) * 0.25 * np.pi + 0.1)
@pytest.mark.parametrize("speed", [0.5, 0.55])
def test_a_standing_robot_steps_after_a_large_one_and_stands_again(direction, speed):
    robot, modes = stood(heading_vector(direction, speed, 0.0))
    s = robot.state
    assert Mode.SWING in modes
    assert (mode_of(s), s.clock.steps > 0) == (Mode.STAND, True)
    between = heading_vector(-s.command.yaw, *(s.robot.feet[0] - s.robot.feet[1])[:2])
    np.testing.assert_allclose(between, [0.0, 0.16], atol=1e-9)
    np.testing.assert_allclose(robot.com[:2], s.robot.feet[:, :2].mean(axis=0), atol=0.02)
