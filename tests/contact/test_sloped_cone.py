"""Cones of lines on ground that rises across them as well, against forces of two points."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from drake_linefoot.contact.wrench_cone import (
    LEVEL,
    line_cone,
    turn_across,
    world_cone,
    world_cones,
)
from tests.helpers.cones import turned_cone
from tests.helpers.walking import ground_cone

MU, X = 0.6, 0.075
angles = st.floats(-3.0, 3.0)
rises = st.floats(-0.4, 0.4)
slopes = st.tuples(rises, rises).map(np.array)
shares = st.floats(-1.0, 1.0)
# Of a pyramid: x and y forces as shares of what friction allows, and the normal force.
inside = st.tuples(shares, shares, st.floats(0.0, 300.0))


def line_on(slope, yaw):
    """Frames of a line on a plane: C with y level, and that of the ground with z its normal."""
    x = np.array([np.cos(yaw), np.sin(yaw), slope @ [np.cos(yaw), np.sin(yaw)]])
    x /= np.linalg.norm(x)
    level = np.array([-np.sin(yaw), np.cos(yaw), 0.0])
    normal = np.array([-slope[0], -slope[1], 1.0])
    normal /= np.linalg.norm(normal)
    R_WC = np.column_stack([x, level, np.cross(x, level)])
    return R_WC, np.column_stack([x, np.cross(normal, x), normal])


def cone_of(R_WC, slope):
    return world_cone(line_cone(MU, X), R_WC, slope)


def wrench_of(R_WC, ground, heel, toe):
    """Forces in W and torques in C of two point forces given in the frame of the ground."""
    heel, toe = ground @ heel, ground @ toe
    moment = R_WC.T @ np.cross(X * ground[:, 0], toe - heel)
    assert abs(moment[0]) < 1e-9  # a line carries no moment about itself
    return np.array([*(heel + toe), *moment[1:]])


def force(part):
    x, y, z = part
    return np.array([x * MU * z, y * MU * z, z])


@given(slopes, angles, inside, inside)
def test_forces_inside_the_true_pyramids_are_inside(slope, yaw, heel, toe):
    R_WC, ground = line_on(slope, yaw)
    u = wrench_of(R_WC, ground, force(heel), force(toe))
    assert (cone_of(R_WC, slope) @ u).max() < 1e-9


@given(slopes, angles, st.sampled_from([-1.0, 1.0]), st.floats(1.0, 300.0), st.integers(0, 1))
def test_forces_outside_the_true_pyramids_are_outside(slope, yaw, sign, size, axis):
    """A thousandth beyond friction at heel and toe, along the line and across it; and a pull."""
    R_WC, ground = line_on(slope, yaw)
    f = np.array([0.0, 0.0, size])
    f[axis] = sign * 1.001 * MU * size
    assert (cone_of(R_WC, slope) @ wrench_of(R_WC, ground, f, f)).max() > 0.0
    pull = np.array([0.0, 0.0, -1e-3 * size])
    assert (cone_of(R_WC, slope) @ wrench_of(R_WC, ground, f * [0, 0, 1], pull)).max() > 0.0


@given(slopes, angles)
def test_everything_turned_by_hand_is_the_same(slope, yaw):
    """The frame of the ground is C turned about the line."""
    R_WC, ground = line_on(slope, yaw)
    c, s = turn_across(R_WC, slope)
    turned = R_WC @ Rotation.from_euler("x", np.arctan2(s, c)).as_matrix()
    np.testing.assert_allclose(turned, ground, atol=1e-14)
    assert c > 0.0
    np.testing.assert_allclose(cone_of(R_WC, slope), ground_cone(MU, X, R_WC, slope), atol=1e-14)


@given(slopes, angles, st.floats(-0.5, 0.5))
def test_a_line_that_does_not_lie_on_the_ground_keeps_its_own_pitch(slope, yaw, pitch):
    """Only the turn about it is taken from the ground: a toe in the air has the foot's cone."""
    R_WC = Rotation.from_euler("ZY", [yaw, pitch]).as_matrix()
    np.testing.assert_allclose(cone_of(R_WC, slope), ground_cone(MU, X, R_WC, slope), atol=1e-14)


@given(angles)
def test_on_level_ground_it_is_the_cone_of_the_foot(yaw):
    R = Rotation.from_euler("z", yaw).as_matrix()
    np.testing.assert_allclose(cone_of(R, LEVEL), turned_cone(MU, X, R), atol=1e-15)


@given(angles, st.floats(-0.4, 0.4))
def test_straight_up_a_slope_it_is_the_cone_of_the_foot(yaw, rise):
    """Then the y axis of the line is level, and so is the ground across it."""
    R_WC, ground = line_on(rise * np.array([np.cos(yaw), np.sin(yaw)]), yaw)
    np.testing.assert_allclose(R_WC, ground, atol=1e-15)
    slope = rise * np.array([np.cos(yaw), np.sin(yaw)])
    np.testing.assert_allclose(cone_of(R_WC, slope), turned_cone(MU, X, ground), atol=1e-14)


def test_across_a_slope_the_normal_leans_as_the_ground_does():
    """Known answer: the line along x, the ground 10 degrees up to the left."""
    R_WC, slope = np.eye(3), np.array([0.0, np.tan(np.radians(10.0))])
    angle = np.arctan2(*turn_across(R_WC, slope)[::-1])
    assert np.degrees(angle) == pytest.approx(10.0, abs=1e-12)


@given(slopes, angles)
def test_mirrored_ground_has_the_mirrored_cone(slope, yaw):
    R_WC, _ = line_on(slope, yaw)
    other, _ = line_on(slope * [1, -1], -yaw)
    flip = np.array([1.0, -1.0, 1.0, 1.0, -1.0])
    rows = cone_of(R_WC, slope) * flip
    mirrored = cone_of(other, slope * [1, -1])
    for row in rows:  # those for tau_z and for -tau_z change places
        assert np.abs(mirrored - row).max(axis=1).min() < 1e-13


def test_many_frames_at_once():
    slopes = np.array([[0.1, -0.2], [0.0, 0.0], [-0.15, 0.05]])
    frames = np.array([line_on(s, yaw)[0] for s, yaw in zip(slopes, (0.0, 1.0, -2.0), strict=True)])
    many = world_cones(line_cone(MU, X), frames, slopes)
    each = [cone_of(R, slope) for R, slope in zip(frames, slopes, strict=True)]
    np.testing.assert_array_equal(many, each)
