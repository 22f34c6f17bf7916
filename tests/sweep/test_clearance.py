"""How far the legs are from each other."""

import numpy as np
import pytest

from drake_linefoot.robot.humanoid import load_humanoid
from drake_linefoot.sweep.clearance import (
    LIMB_RADIUS,
    leg_clearance,
    leg_segments,
    segment_distance,
)


def test_distance_of_segments_is_the_smallest_of_their_points():
    rng = np.random.default_rng(0)
    a, b = rng.normal(size=(2, 200, 2, 3))
    b[:50, 1] = b[:50, 0] + (a[:50, 1] - a[:50, 0])  # parallel ones
    b[50:60] = a[50:60, ::-1]  # the same, the other way
    share = np.linspace(0.0, 1.0, 201)
    P = a[:, :1] + share[:, None] * (a[:, 1:] - a[:, :1])
    Q = b[:, :1] + share[:, None] * (b[:, 1:] - b[:, :1])
    found = segment_distance(a, b)
    for i in range(len(a)):
        tried = np.linalg.norm(P[i, :, None] - Q[i, None], axis=2).min()
        assert tried - 0.03 < found[i] <= tried + 1e-9


def test_segments_are_those_of_the_legs():
    humanoid = load_humanoid("mit_humanoid")
    ((left, right),) = leg_segments(humanoid, humanoid.q_nominal[None])
    assert left * [1, -1, 1] == pytest.approx(right, abs=1e-9)  # mirror images
    heel, toe = left[0]
    assert toe - heel == pytest.approx([2.0 * humanoid.half_length, 0.0, 0.0], abs=1e-6)
    assert heel[2] == pytest.approx(LIMB_RADIUS, abs=1e-6)  # the pad touches the ground
    knee, ankle = left[1]
    assert np.linalg.norm(knee - ankle) == pytest.approx(0.2785)  # the shank, parameters.yaml


def test_clearance_falls_as_the_legs_close():
    humanoid = load_humanoid("mit_humanoid")
    q = np.tile(humanoid.q_nominal, (6, 1))
    abad = humanoid.actuated_q[humanoid.description.actuated_joints.index("left_hip_abad")]
    q[:, abad] = np.linspace(0.2, -0.8, 6)
    gap = leg_clearance(humanoid, q)
    assert gap[0] > gap[1] > gap[2] > 0.0
    assert gap.min() < 0.0
    straight = leg_clearance(humanoid, humanoid.q_nominal[None])[0]
    ((left, right),) = leg_segments(humanoid, humanoid.q_nominal[None])
    assert straight <= left[0, 0, 1] - right[0, 0, 1] - 2.0 * LIMB_RADIUS + 1e-9
