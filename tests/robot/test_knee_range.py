"""A knee that could be bent the wrong way ends at the straight leg."""

import numpy as np
import pytest

from drake_linefoot.lab.new_robot.analysis import analyse
from drake_linefoot.robot.knee_range import knee_range
from drake_linefoot.robot.legs import leg_roles, read_legs
from drake_linefoot.wbc.joint_limits import leg_limits
from drake_linefoot.wbc.parameters import WbcParameters
from tests.helpers.made_up_robots import bound, mit, turn_knees, write
from tests.helpers.walking import robot

MARGIN = WbcParameters().joint_limit_margin


@pytest.fixture(scope="module", params=[False, True], ids=["ahead", "backward"])
def both_ways(request, tmp_path_factory):
    """A robot whose knees could also bend 0.3 rad the other way."""
    tree = mit()
    bound(tree, "knee", -0.3, 2.2)
    if request.param:
        turn_knees(tree)
    return analyse(write(tree, tmp_path_factory.mktemp("knees"))).humanoid


def leg_length(humanoid, angle):
    """From hip to ankle, with one knee at an angle, by the plant [m]."""
    plant, context = humanoid.plant, humanoid.plant.CreateDefaultContext()
    plant.GetJointByName("left_knee").set_angle(context, angle)
    hip, ankle = (
        plant.GetJointByName(f"left_{name}").frame_on_child().CalcPoseInWorld(context).translation()
        for name in ("hip_pitch", "ankle")
    )
    return np.linalg.norm(ankle - hip)


def test_it_ends_where_the_leg_is_longest(both_ways):
    h, sign = both_ways, np.sign(both_ways.q_nominal[both_ways.leg_q[0, leg_roles(both_ways).knee]])
    roles, legs = leg_roles(h), read_legs(h)
    found = knee_range(legs, 0, h.q_nominal[h.leg_q[0]], roles.knee)
    straight, bent = sorted(found, key=abs)
    assert bent == pytest.approx(2.2 * sign)
    longest = leg_length(h, straight)
    assert longest > leg_length(h, straight + 0.01)
    assert longest > leg_length(h, straight - 0.01)


def test_the_controller_keeps_off_the_straight_leg(both_ways):
    limits = leg_limits(both_ways, WbcParameters())
    ends = np.array([limits.lower, limits.upper])[:, :, limits.knee]
    np.testing.assert_allclose(np.min(np.abs(ends), axis=0), MARGIN, atol=1e-9)
    assert (np.sign(ends) == np.sign(both_ways.q_nominal[both_ways.leg_q[:, limits.knee]])).all()


def test_a_knee_that_cannot_bend_the_other_way_keeps_its_limits():
    """To the bit, with a limit at the straight leg itself."""
    legs, knee = read_legs(robot()), leg_roles(robot()).knee
    for leg in range(2):
        q = robot().q_nominal[robot().leg_q[leg]]
        assert knee_range(legs, leg, q, knee) == (legs.lower[leg, knee], legs.upper[leg, knee])
