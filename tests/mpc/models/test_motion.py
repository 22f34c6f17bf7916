"""Contacts as they are planned: lines level across, soles flat on the ground."""

import numpy as np
import pytest

from drake_linefoot.gait.swing import LineMotion
from drake_linefoot.mpc.models.motion import line_plan

K = 8


def planned(nw, slope, seed=0):
    """Frames of feet with random headings whose x axes lie in the plane of a slope."""
    rng = np.random.default_rng(seed)
    yaw = rng.uniform(-3.0, 3.0, (2, K))
    rise = np.cos(yaw) * slope[0] + np.sin(yaw) * slope[1]
    position, velocity = rng.normal(size=(2, 2, K, 5))
    position[..., 3], position[..., 4] = -np.arctan(rise), yaw
    lines = line_plan(
        LineMotion(position, velocity, np.zeros((2, K, 5))), np.tile(slope, (K, 2, 1)), nw
    )
    return lines, position, velocity


@pytest.mark.parametrize("slope", [(0.0, 0.0), (0.0, 0.17), (0.1, -0.2)])
def test_soles_lie_flat_and_lines_are_level_across(slope):
    slope = np.array(slope)
    normal = np.array([*-slope, 1.0]) / np.sqrt(1.0 + slope @ slope)
    for nw in (5, 6):
        lines, position, velocity = planned(nw, slope)
        np.testing.assert_array_equal(lines.p, position[..., :3])
        np.testing.assert_array_equal(lines.v, velocity[..., :3])
        np.testing.assert_allclose(
            np.swapaxes(lines.R, -1, -2) @ lines.R, np.broadcast_to(np.eye(3), (2, K, 3, 3)),
            atol=1e-12,
        )  # fmt: skip
        np.testing.assert_allclose(np.linalg.det(lines.R), 1.0)
        np.testing.assert_allclose(lines.R[..., 0] @ normal, 0.0, atol=1e-12)
        heading = np.arctan2(lines.R[..., 1, 0], lines.R[..., 0, 0])
        np.testing.assert_allclose(heading, position[..., 4])
        across = lines.R[..., 1]
        level = np.abs(across[..., 2]).max()
        if nw == 6:
            np.testing.assert_allclose(
                lines.R[..., 2], np.broadcast_to(normal, (2, K, 3)), atol=1e-12
            )
            assert (level > 0.05) == slope.any()
        else:
            assert level < 1e-12


def test_both_are_the_same_on_level_ground():
    for line, sole in zip(planned(5, np.zeros(2))[0], planned(6, np.zeros(2))[0], strict=True):
        np.testing.assert_allclose(line, sole, atol=1e-12)


def test_feet_turn_as_pitch_and_yaw_change():
    """By central differences of the frames, on level ground."""
    rng, h = np.random.default_rng(1), 1e-6
    position, velocity = rng.uniform(-0.5, 0.5, (2, 2, K, 5))
    zero, level = np.zeros((2, K, 5)), np.zeros((K, 2, 2))
    for nw in (5, 6):

        def frames(t, nw=nw):
            return line_plan(LineMotion(position + t * velocity, velocity, zero), level, nw)

        rate = (frames(h).R - frames(-h).R) / (2.0 * h)
        W = rate @ np.swapaxes(frames(0.0).R, -1, -2)  # the cross product with w
        turning = np.stack([W[..., 2, 1], W[..., 0, 2], W[..., 1, 0]], axis=-1)
        np.testing.assert_allclose(frames(0.0).w, turning, atol=1e-8)
