"""Pictures of robots: seen from the right, whatever way they go; everything in them is there."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from drake_linefoot.lab.results.poses import POSES, SIDE, draw_robot, draw_walk, link_clouds
from tests.helpers.recorded_runs import short_run


def boxes(figure):
    """The least and the largest x and z of every link of a picture."""
    outlines = [patch.get_xy() for patch in figure.axes[0].patches]
    return np.array([[xz.min(axis=0), xz.max(axis=0)] for xz in outlines])


def test_poses_are_seen_from_the_right_whatever_way_a_robot_goes(humanoid):
    run = short_run()
    before = boxes(draw_walk(run))
    q = np.array(run.q)
    turn = Rotation.from_euler("z", 2.0)
    q[:, :4] = (turn * Rotation.from_quat(q[:, :4], scalar_first=True)).as_quat(scalar_first=True)
    q[:, 4:6] += [3.0, -1.0]
    np.testing.assert_allclose(boxes(draw_walk(replace(run, q=q))), before, atol=1e-9)
    links = len(link_clouds(humanoid))
    assert len(draw_walk(run).axes[0].patches) == POSES * links
    assert abs(before[..., 1].min()) < 0.01  # [m]: feet stand on the ground


def test_a_robot_is_drawn_from_two_sides_with_its_contacts_and_its_centre_of_mass(humanoid):
    side, front = draw_robot(humanoid).axes
    humanoid.plant.SetPositions(humanoid.scratch, humanoid.q_nominal)
    com = humanoid.plant.CalcCenterOfMassPositionInWorld(humanoid.scratch)
    *feet, found, _ = side.lines
    assert [len(foot.get_xdata()) for foot in feet] == [2, 2]  # heel and toe
    np.testing.assert_allclose(np.ravel(found.get_data()), com[list(SIDE)])
    assert len(side.patches) == len(front.patches)
    assert front.xaxis_inverted()  # its left is on the right
