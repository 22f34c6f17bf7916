"""How far the legs are from each other."""

import numpy as np
import pytest

from drake_linefoot.lab.new_robot.analysis import analyse
from drake_linefoot.lab.plants.ground import Ground
from drake_linefoot.lab.results.clearance import LIMB_RADIUS, leg_clearance, shank_clearance
from drake_linefoot.lab.scenario.courses import StairsParameters
from drake_linefoot.lab.scenario.scene import Scene
from drake_linefoot.robot.humanoid import load_humanoid
from tests.helpers import made_up_robots as made_up
from tests.helpers.similar import LENGTH, similar_robot

SHARE = np.linspace(0.0, 1.0, 101)[:, None]
UP = np.array([0.0, 0.0, LIMB_RADIUS])


@pytest.fixture(scope="module")
def humanoid():
    return load_humanoid("mit_humanoid")


def axes(humanoid, q):
    """Points on the axes of the limbs of each leg: above heel to toe, knee to ankle."""
    plant, context = humanoid.plant, humanoid.plant.CreateDefaultContext()
    plant.SetPositions(context, q)
    legs = []
    for frame, foot in zip(humanoid.foot_frames, humanoid.description.feet, strict=True):
        ends = foot.contact_points + UP
        heel, toe = (frame.CalcPoseInWorld(context) @ ends.T).T
        knee, ankle = (
            plant.GetJointByName(name).frame_on_child().CalcPoseInWorld(context).translation()
            for name in foot.leg_joints[-2:]
        )
        legs.append(np.concatenate([heel + SHARE * (toe - heel), knee + SHARE * (ankle - knee)]))
    return legs


def test_clearance_is_the_smallest_distance_of_the_limbs(humanoid):
    rng = np.random.default_rng(0)
    q = np.tile(humanoid.q_nominal, (40, 1))
    q[:, humanoid.actuated_q] += rng.uniform(-0.5, 0.5, (40, humanoid.na))
    found = leg_clearance(humanoid, q)
    assert found.min() < 0.0 < found.max()
    for row, gap in zip(q, found, strict=True):
        left, right = axes(humanoid, row)
        tried = np.linalg.norm(left[:, None] - right, axis=2).min() - 2.0 * LIMB_RADIUS
        assert tried - 0.003 < gap < tried + 0.0005


def test_limbs_are_those_of_the_legs(humanoid):
    left, right = axes(humanoid, humanoid.q_nominal)
    assert left * [1, -1, 1] == pytest.approx(right, abs=1e-9)  # mirror images
    heel, toe = left[[0, 100]]
    assert toe - heel == pytest.approx([2.0 * humanoid.half_length, 0.0, 0.0], abs=1e-6)
    assert heel[2] == pytest.approx(LIMB_RADIUS, abs=1e-6)  # the pad touches the ground
    knee, ankle = left[[101, 201]]
    assert np.linalg.norm(knee - ankle) == pytest.approx(0.2785)  # the shank, parameters.yaml


def test_clearance_falls_as_the_legs_close(humanoid):
    q = np.tile(humanoid.q_nominal, (6, 1))
    abad = humanoid.actuated_q[humanoid.description.actuated_joints.index("left_hip_abad")]
    q[:, abad] = np.linspace(0.2, -0.8, 6)
    gap = leg_clearance(humanoid, q)
    assert gap[0] > gap[1] > gap[2] > 0.0
    assert gap.min() < 0.0
    straight = leg_clearance(humanoid, humanoid.q_nominal[None])[0]
    left, right = axes(humanoid, humanoid.q_nominal)
    assert straight <= left[0, 1] - right[0, 1] - 2.0 * LIMB_RADIUS + 1e-4


def test_wide_feet_are_apart_by_what_is_between_their_shapes(tmp_path):
    tree = made_up.mit()
    made_up.box_feet(tree)
    robot = analyse(made_up.write(tree, tmp_path)).humanoid
    assert robot.sole_width == pytest.approx(made_up.BOX[1])
    left, right = axes(robot, robot.q_nominal)
    between = left[0, 1] - right[0, 1]  # of the lines, which are level and parallel
    gap = leg_clearance(robot, robot.q_nominal[None])[0]
    assert gap == pytest.approx(between - made_up.BOX[1], abs=1e-4)


def test_limbs_are_in_the_size_of_the_robot(humanoid, tmp_path):
    small = load_humanoid(similar_robot(tmp_path))
    q = np.tile(humanoid.q_nominal, (5, 1))
    q[:, humanoid.actuated_q] += np.random.default_rng(1).uniform(-0.5, 0.5, (5, humanoid.na))
    gap = leg_clearance(humanoid, q)
    q[:, 4:7] *= LENGTH
    np.testing.assert_allclose(leg_clearance(small, q), LENGTH * gap, atol=1e-4)


def test_a_shank_meets_a_riser_that_it_walks_into(humanoid):
    """As it stands a shank is beside its ankle, so a step that begins there is in its way."""
    q = humanoid.q_nominal
    knee, ankle = axes(humanoid, q)[0][[101, 201]]
    lowest = ankle + ankle[2] / np.linalg.norm(knee - ankle) * (knee - ankle)
    free = lowest[2] - LIMB_RADIUS
    assert shank_clearance(humanoid, Ground(), q[None]) == pytest.approx(free, abs=1e-9)
    ahead = max(knee[0], lowest[0])
    for away in (0.05, 0.0):
        at = ahead + LIMB_RADIUS + away
        stairs = StairsParameters(rise=0.4, tread=[0.3, 0.3], steps=2, at=at)
        gap = shank_clearance(humanoid, Ground(Scene(stairs=stairs)), q[None])[0]
        assert gap == pytest.approx(min(away, free), abs=1e-9)
    stairs = StairsParameters(rise=0.4, tread=[0.3, 0.3], steps=2, at=ahead)
    assert shank_clearance(humanoid, Ground(Scene(stairs=stairs)), q[None])[0] < -0.9 * LIMB_RADIUS
