"""Robots with fewer and with more joints stand like the one they come from."""

import numpy as np
import pytest

from studies.common import models
from studies.common.models import carried_over, with_extra_joints, without_arms
from tests.helpers.walked import walk


@pytest.mark.parametrize(("make", "joints"), [(without_arms, 10), (with_extra_joints, 23)])
def test_variants_have_their_joints_and_their_mass(tmp_path, make, joints):
    original = walk().humanoid
    robot = make(original, tmp_path)
    extra = models.EXTRA_MASS * len(models.EXTRA_AXES) if make is with_extra_joints else 0.0
    assert robot.na == joints
    assert robot.mass == pytest.approx(original.mass + extra, abs=1e-9)  # [kg]


@pytest.mark.parametrize("make", [without_arms, with_extra_joints])
def test_carried_over_state_has_the_feet_where_they_were(tmp_path, make):
    original = walk().humanoid
    robot = make(original, tmp_path)
    state = walk().walking_ticks(1)[0].before.x
    x = carried_over(state, original, robot)
    for one, y in ((original, state), (robot, x)):
        context = one.plant.CreateDefaultContext()
        one.plant.SetPositionsAndVelocities(context, y)
        feet = [frame.CalcPoseInWorld(context).translation() for frame in one.foot_frames]
        if one is original:
            expected = feet
    np.testing.assert_allclose(feet, expected, atol=1e-9)  # [m]
