"""What is said of a recorded push: on runs that nobody simulated."""

import numpy as np
import pytest

from drake_linefoot.gait.constants import constants_of
from drake_linefoot.lab.results import viability
from drake_linefoot.lab.results.viability import push_is_viable, step_bounds
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.scenario.disturbances import PushParameters
from tests.helpers.falls import HUMANOID, LIFT, TIME, channels, fallen, swing

END = LIFT + 0.05  # [s] of the push, while the right foot is in the air


def pushed(velocity, swings=True, end=END):
    """A run in which the CoM has a velocity when a push ends."""
    values = swing(channels()) if swings else channels()
    values["com"][:, :2] += np.maximum(TIME - end + 0.1, 0.0)[:, None] * velocity
    values["com"][:, :2] -= 0.1 * np.asarray(velocity)
    run = fallen(values)
    run.scenario.pushes = [PushParameters(time=end - 0.1, impulse=10.0)]
    return run


@pytest.mark.parametrize(
    ("velocity", "viable"),
    [
        ([0.0, 0.0], True),
        ([1.0, 0.0], True),
        ([4.8, 0.0], False),
        ([0.0, -0.8], True),  # towards the swing foot
        ([0.0, -1.9], False),
        ([0.0, 0.6], True),  # across the stance foot, which no step crosses
        ([0.0, 1.5], False),
    ],
)
def test_it_is_that_of_a_pendulum_on_the_stance_foot(velocity, viable):
    assert push_is_viable(pushed(velocity)) is viable


def test_a_robot_on_both_feet_may_choose_which_to_lift():
    """To either side it takes as much, for the foot of that side steps out."""
    assert push_is_viable(pushed([0.0, 0.9], swings=False)) is True
    assert push_is_viable(pushed([0.0, -0.9], swings=False)) is True


def test_without_a_push_or_its_end_there_is_nothing_to_say():
    run = pushed([0.0, 0.0])
    run.scenario.pushes = []
    assert push_is_viable(run) is None
    assert push_is_viable(pushed([0.0, 0.0], end=TIME[-1] + 0.05)) is None


def test_of_legs_too_slow_for_steps_so_wide_nothing_is_said(monkeypatch):
    """As of Romeo's: its narrowest step throws the pendulum farther than its widest one reaches."""

    def wide(c):
        return step_bounds(c)._replace(limits=np.array([0.5, 0.3, 0.4]))

    monkeypatch.setattr(viability, "step_bounds", wide)
    assert push_is_viable(pushed([0.0, 0.0])) is None


def test_quickest_step_is_that_of_the_robots_legs():
    bounds = step_bounds(constants_of(Scenario().gait, HUMANOID)[0])
    assert 0.08 < bounds.duration < 0.16
    np.testing.assert_array_equal(bounds.limits, [0.5, 0.1, 0.45])


def test_quickest_step_is_a_recovery_step():
    """Its double support lasts 12 ms, where the steps of a steady walk have 30."""
    steady = Scenario()
    steady.gait.double_support_min = 1.0  # then recovery steps have those of a steady walk
    slow, quick = (step_bounds(constants_of(s.gait, HUMANOID)[0]) for s in (steady, Scenario()))
    assert slow.duration - quick.duration == pytest.approx(0.018)
