"""The wrench cone of a rectangle [28] against forces at its corners, and against that of a line."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.optimize import linprog

from drake_linefoot.contact.surface import SurfaceContact, surface_cone
from drake_linefoot.contact.wrench_cone import LEVEL, line_cone, world_cone
from tests.helpers.cones import corner_excess, grasp

lengths = st.floats(0.02, 0.2)
frictions = st.floats(0.2, 1.2)
shares = st.floats(-1.0, 1.0)


@given(forces=arrays(float, (4, 3), elements=shares), X=lengths, Y=lengths, mu=frictions)
def test_forces_of_corners_give_wrenches_inside_the_rows(forces, X, Y, mu):
    forces[:, 2] = 100.0 * np.abs(forces[:, 2])
    forces[:, :2] *= mu * forces[:, 2:]
    w = grasp(X, Y) @ forces.ravel()
    assert (SurfaceContact(X, Y).cone(mu) @ w).max() <= 1e-10 * 400.0


@given(w=arrays(float, 5, elements=shares), X=lengths, Y=lengths, mu=frictions)
def test_a_wrench_is_inside_the_rows_when_forces_of_corners_make_it(w, X, Y, mu):
    """Both ways: each wrench is either, by a linear program."""
    f_x, f_y, tau_y, tau_z, tau_x = w * [mu, mu, X, mu * (X + Y), Y]
    w = 100.0 * np.array([f_x, f_y, 1.0, tau_y, tau_z, tau_x])
    excess = corner_excess(w, X, Y, mu)
    assume(abs(excess) > 1e-6)
    assert bool(np.all(SurfaceContact(X, Y).cone(mu) @ w <= 0.0)) == (excess < 0.0)


@given(X=lengths, Y=lengths, mu=frictions)
def test_every_row_is_needed(X, Y, mu):
    """Without it the others let a wrench pass that it forbids."""
    cone = SurfaceContact(X, Y).scaled().cone(mu)
    for row in range(16):
        others = np.delete(cone, row, axis=0)
        found = linprog(-cone[row], others, np.zeros(15), bounds=(-1.0, 1.0))
        assert -found.fun > 1e-3


def test_one_row_written_out():
    """A rectangle of 0.2 m by 0.1 m, with friction 0.5: tau_z - 0.075 f_z is at most
    -|0.05 f_x + 0.5 tau_x| - |0.1 f_y + 0.5 tau_y|.
    """
    cone = surface_cone(0.5, 0.1, 0.05)
    assert [0.05, 0.1, -0.075, 0.5, 1.0, 0.5] in cone.round(12).tolist()
    assert [-0.05, 0.1, -0.075, -0.5, -1.0, 0.5] in cone.round(12).tolist()


@given(w=arrays(float, 6, elements=shares), X=lengths, mu=frictions)
def test_without_a_width_it_is_the_line(w, X, mu):
    w = w * [mu, mu, 1.0, X, mu * X, X]
    w[2] = 1.0
    line = (line_cone(mu, X) @ w[:5]).max()
    assume(abs(line) > 1e-9 and abs(w[5]) > 1e-9)
    assert not np.all(surface_cone(mu, X, 0.0) @ w <= 0.0)  # tau_x
    w[5] = 0.0
    assert bool(np.all(surface_cone(mu, X, 0.0) @ w <= 0.0)) == (line < 0.0)


@pytest.mark.parametrize("rise", [0.0, 0.2])
@given(forces=arrays(float, (4, 3), elements=shares), yaw=st.floats(-3.0, 3.0))
def test_on_ground_that_rises_across_it_corners_press_on_the_ground(rise, forces, yaw):
    """Frame C has y level; the pyramids of the corners stand on the ground, turned about x of C."""
    X, Y, mu = 0.1, 0.04, 0.6
    x, y = np.array([np.cos(yaw), np.sin(yaw), 0.0]), np.array([-np.sin(yaw), np.cos(yaw), 0.0])
    R_WC, slope = np.column_stack([x, y, [0.0, 0.0, 1.0]]), rise * y[:2]
    up = np.array([-slope[0], -slope[1], 1.0]) / np.hypot(1.0, rise)
    R_WS = np.column_stack([x, np.cross(up, x), up])
    forces[:, 2] = 100.0 * np.abs(forces[:, 2])
    forces[:, :2] *= mu * forces[:, 2:]
    w = grasp(X, Y) @ forces.ravel()  # in the ground's frame
    force, torque = R_WS @ w[:3], R_WC.T @ R_WS @ w[[5, 3, 4]]
    in_world = np.concatenate([force, torque[[1, 2, 0]]])
    rows = world_cone(SurfaceContact(X, Y).cone(mu), R_WC, slope)
    np.testing.assert_allclose(rows @ in_world, SurfaceContact(X, Y).cone(mu) @ w, atol=1e-9)
    assert (rows @ in_world).max() <= 1e-9
    np.testing.assert_array_equal(
        world_cone(SurfaceContact(X, Y).cone(mu), np.eye(3), LEVEL), SurfaceContact(X, Y).cone(mu)
    )
