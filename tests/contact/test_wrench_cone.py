"""The line-contact cone (18) against two point contacts (9), both ways, and against (10)-(15)."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.optimize import linprog, nnls
from scipy.spatial.transform import Rotation

from drake_linefoot.contact.contacts import LineContact
from drake_linefoot.contact.wrench_cone import (
    LEVEL,
    force_cone,
    line_cone,
    point_cone,
    points_from_wrench,
    with_friction,
    world_cone,
)
from drake_linefoot.robot.dynamics import contact_frame
from tests.helpers.cones import full_line_cone, wrench_from_points

BOTH = np.ones(2)  # heel and toe
FRICTION = st.floats(0.05, 2.0)
HALF_LENGTH = st.floats(0.02, 0.3)
UNIT = st.floats(-1.0, 1.0)
SHARE = st.floats(0.0, 1.0)
ROUNDING = 1e-12  # [-] of the normal force times what it is compared with

ENDS = LineContact.ends


def excess_of_point(f, mu):
    """Return how far a force is outside (9); negative inside."""
    f_x, f_y, f_z = f
    return max(abs(f_x) - mu * f_z, abs(f_y) - mu * f_z, -f_z)


def excess_18(w, mu, X):
    """Return how far a wrench is outside (18), as printed; negative inside."""
    f_x, f_y, f_z, tau_y, tau_z = w
    return max(
        abs(f_x) - mu * f_z,
        tau_z - (mu * X * f_z - abs(X * f_y + mu * tau_y)),
        (-mu * X * f_z + abs(X * f_y - mu * tau_y)) - tau_z,
    )


def excess_10_to_15(w, mu, X):
    """Return how far a wrench is outside (10)-(12), (14), (15), as printed."""
    f_x, f_y, f_z, tau_y, tau_z = w
    return max(
        abs(f_x) - mu * f_z,
        abs(f_y) - mu * f_z,
        -f_z,
        abs(tau_y) - X * f_z,
        (-mu * X * f_z + abs(X * f_y - mu * tau_y)) - tau_z,
        tau_z - (mu * X * f_z - abs(X * f_y + mu * tau_y)),
    )


@st.composite
def point_forces(draw, mu):
    """A force inside (9), often on its edges."""
    f_z = draw(st.floats(0.0, 500.0))
    return np.array([draw(UNIT) * mu * f_z, draw(UNIT) * mu * f_z, f_z])


@st.composite
def wrenches(draw, mu, X):
    """A wrench inside (18): the rest of a random one is shrunk until it just fits."""
    f_z = draw(st.floats(1e-3, 500.0))
    direction = np.array([draw(UNIT), draw(UNIT), 0.0, draw(UNIT) * X, draw(UNIT) * X])
    # (18) grows in proportion along `direction`: its excess is e(s) = s e1 - room.
    low, high = 0.0, 2.0 * max(mu, 1.0) * f_z * 10.0
    for _ in range(80):
        middle = 0.5 * (low + high)
        w = middle * direction + [0.0, 0.0, f_z, 0.0, 0.0]
        low, high = (middle, high) if excess_18(w, mu, X) <= 0.0 else (low, middle)
    w = draw(SHARE) * low * direction
    w[2] = f_z
    return w


# --- shapes and refusals --------------------------------------------------------------------


def test_six_rows_in_five_variables():
    assert line_cone(0.8, 0.075).shape == (6, 5)
    assert full_line_cone(0.8, 0.075).shape == (11, 5)


@pytest.mark.parametrize("bad", [0.0, -0.5, np.nan, np.inf])
def test_meaningless_constants_are_refused(bad):
    wrench = np.array([0.0, 0.0, 1.0, 0.0, 0.0])
    for call in (
        lambda: point_cone(bad),
        lambda: line_cone(bad, 0.1),
        lambda: points_from_wrench(wrench, 0.1, bad),
    ):
        with pytest.raises(ValueError, match="friction"):
            call()
    for call in (
        lambda: line_cone(0.8, bad),
        lambda: points_from_wrench(wrench, bad, 0.8),
    ):
        with pytest.raises(ValueError, match="half length"):
            call()


# --- the rows are the printed inequalities ----------------------------------------------------


@given(st.data(), FRICTION)
def test_point_cone_is_9(data, mu):
    f = data.draw(arrays(float, 3, elements=st.floats(-100, 100)))
    W = point_cone(mu)
    assert W.shape == (4, 3)
    excess, rows = excess_of_point(f, mu), (W @ f).max()
    if abs(excess) > 1e-9:  # 0 <= f_z is not among the rows and yet never decides
        assert (rows <= 0.0) == (excess <= 0.0)


@given(st.data(), FRICTION, HALF_LENGTH)
def test_rows_are_the_printed_inequalities(data, mu, X):
    w = data.draw(arrays(float, 5, elements=st.floats(-100, 100))) * [1, 1, 1, X, X]
    scale = ROUNDING * 100 * max(mu, 1.0)
    assert (line_cone(mu, X) @ w).max() == pytest.approx(excess_18(w, mu, X), abs=scale)
    full = (full_line_cone(mu, X) @ w).max()
    assert full == pytest.approx(excess_10_to_15(w, mu, X), abs=scale)


@given(st.data(), FRICTION, HALF_LENGTH)
def test_full_and_simplified_cone_agree(data, mu, X):
    """Also next to the boundary: a wrench is put on it, then moved off by a little."""
    w = data.draw(wrenches(mu, X))
    off = data.draw(arrays(float, 5, elements=UNIT)) * [1, 1, 1, X, X]
    w = w + data.draw(st.sampled_from([0.0, 1e-6, 1e-2, 10.0])) * off
    simple, full = excess_18(w, mu, X), excess_10_to_15(w, mu, X)
    margin = 1e-9 * (1.0 + np.abs(w).max())
    if abs(simple) > margin and abs(full) > margin:
        assert (simple < 0.0) == (full < 0.0)
        inside = bool(np.all(line_cone(mu, X) @ w <= 0.0))
        assert inside == bool(np.all(full_line_cone(mu, X) @ w <= 0.0)) == (simple < 0.0)


@pytest.mark.parametrize(("mu", "X"), [(0.8, 0.075), (0.3, 0.02), (1.5, 0.2)])
def test_redundant_rows_follow_from_the_six_and_no_row_of_the_six_follows(mu, X):
    """Farkas: a row is implied exactly when it is a nonnegative sum of the others."""
    W, full = line_cone(mu, X), full_line_cone(mu, X)
    np.testing.assert_array_equal(full[:6], W)
    for row in full:
        assert nnls(W.T, row)[1] < 1e-12
    for i in range(6):
        assert nnls(np.delete(W, i, axis=0).T, W[i])[1] > 1e-2 * X


# --- two point contacts ---------------------------------------------------------------------


@given(arrays(float, (2, 3), elements=st.floats(-100, 100)), HALF_LENGTH)
def test_wrench_of_two_forces_is_their_sum_and_their_moment(forces, X):
    arms = [[-X, 0.0, 0.0], [X, 0.0, 0.0]]
    moment = np.cross(arms, forces).sum(axis=0)
    assert moment[0] == 0.0  # (13)
    expected = np.concatenate([forces.sum(axis=0), moment[1:]])
    np.testing.assert_allclose(wrench_from_points(*forces, X), expected, rtol=0, atol=1e-12)
    stack = wrench_from_points(np.tile(forces[0], (2, 3, 1)), forces[1], X)
    np.testing.assert_allclose(stack, np.broadcast_to(expected, (2, 3, 5)), rtol=0, atol=1e-12)


@given(st.data(), FRICTION, HALF_LENGTH)
def test_feasible_forces_add_up_to_a_feasible_wrench(data, mu, X):
    heel, toe = data.draw(point_forces(mu)), data.draw(point_forces(mu))
    w = wrench_from_points(heel, toe, X)
    tolerance = ROUNDING * (heel[2] + toe[2]) * max(mu, 1.0)
    assert excess_18(w, mu, X) <= tolerance
    assert (line_cone(mu, X) @ w).max() <= tolerance
    assert (full_line_cone(mu, X) @ w).max() <= tolerance


@given(st.data(), FRICTION, HALF_LENGTH)
def test_feasible_wrenches_split_into_feasible_forces(data, mu, X):
    w = data.draw(wrenches(mu, X))
    heel, toe = points_from_wrench(w, X, mu)
    tolerance = ROUNDING * w[2] * max(mu, 1.0) / X
    assert excess_of_point(heel, mu) <= tolerance
    assert excess_of_point(toe, mu) <= tolerance
    again = wrench_from_points(heel, toe, X)
    np.testing.assert_allclose(again, w, rtol=0, atol=ROUNDING * w[2] * max(mu, 1.0))


@pytest.mark.parametrize(("mu", "X"), [(0.8, 0.075), (0.4, 0.2)])
def test_both_cones_reach_equally_far_in_every_direction(mu, X):
    """max c'w at f_z = 1 over (18), and over pairs of forces in (9): linear programs."""
    rng = np.random.default_rng(0)
    one, points = point_cone(mu), np.zeros((8, 6))
    points[:4, :3] = points[4:, 3:] = one
    # Columns: heel force, toe force.
    add = np.array([wrench_from_points(e[:3], e[3:], X) for e in np.eye(6)]).T
    options = {"bounds": (None, None), "b_eq": [1.0]}
    normal = np.eye(5)[2:3]
    for c in rng.normal(size=(100, 5)) / [1.0, 1.0, 1.0, X, X]:
        over_wrenches = linprog(-c, A_ub=line_cone(mu, X), b_ub=np.zeros(6), A_eq=normal, **options)
        over_forces = linprog(-c @ add, A_ub=points, b_ub=np.zeros(8), A_eq=normal @ add, **options)
        assert over_wrenches.status == over_forces.status == 0
        assert over_wrenches.fun == pytest.approx(over_forces.fun, abs=1e-9)


@pytest.mark.parametrize("signs", list(itertools.product((-1.0, 1.0), repeat=4)))
@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_forces_on_their_edges_give_wrenches_on_the_boundary(signs, share):
    """All friction used up at heel and toe; a little more leaves the cone, less enters it."""
    mu, X, f_z = 0.8, 0.075, 200.0
    weights = np.array([1.0 - share, share]) * f_z
    forces = np.column_stack([np.reshape(signs, (2, 2)) * mu * weights[:, None], weights])
    w = wrench_from_points(*forces, X)
    assert (line_cone(mu, X) @ w).max() == pytest.approx(0.0, abs=1e-12 * f_z)
    for eps, inside in ((-1e-9, False), (1e-9, True)):
        moved = w + eps * f_z * np.eye(5)[2]
        assert bool(np.all(line_cone(mu, X) @ moved <= 0.0)) == inside
        assert (excess_18(moved, mu, X) <= 0.0) == inside


@given(FRICTION, HALF_LENGTH, st.floats(0.05, 1.0))
def test_a_cone_with_less_friction_is_that_of_the_friction(mu, X, share):
    for cone in (line_cone, force_cone):
        np.testing.assert_allclose(
            with_friction(cone(mu, X), ENDS, share * BOTH),
            cone(share * mu, X),
            rtol=1e-12,
            atol=1e-15,
        )
    np.testing.assert_array_equal(with_friction(line_cone(mu, X), ENDS, BOTH), line_cone(mu, X))


@given(FRICTION, HALF_LENGTH, st.floats(0.05, 1.0), st.floats(0.05, 1.0), st.integers(0, 2**32 - 1))
def test_each_end_has_its_own_friction(mu, X, at_heel, at_toe, seed):
    """A wrench is inside where forces at the ends give it that are within the friction there."""
    cone, rng = (
        with_friction(line_cone(mu, X), ENDS, np.array([at_heel, at_toe])),
        np.random.default_rng(seed),
    )
    for forces in rng.uniform([-1.0, -1.0, -0.1], [1.0, 1.0, 1.0], (50, 2, 3)):
        (x_heel, y_heel, z_heel), (x_toe, y_toe, z_toe) = forces
        along = max(at_heel, at_toe) * mu * (z_heel + z_toe) - abs(x_heel + x_toe)
        room = [along, at_heel * mu * z_heel - abs(y_heel), at_toe * mu * z_toe - abs(y_toe)]
        excess = (cone @ wrench_from_points(*forces, X)).max()
        assert (excess <= 0.0) == (min(room) >= 0.0)


@pytest.mark.parametrize("end", [0, 1])
def test_a_foot_on_one_end_resists_no_turn_about_it(end):
    """What the other end could hold is what its least friction gives."""
    mu, X, shares = 0.6, 0.075, np.full(2, 0.05)
    shares[end] = 1.0
    cone = with_friction(line_cone(mu, X), ENDS, shares)
    away = X if end == 0 else -X  # from the middle of the line to the end without friction
    about_the_end = np.array([0.0, away, 0.0, 0.0, 1.0])  # torque about z at the end that bears
    options = {"bounds": (None, None), "A_eq": np.eye(5)[2:3], "b_eq": [1.0]}
    most = -linprog(-about_the_end, A_ub=cone, b_ub=np.zeros(6), **options).fun
    assert most == pytest.approx(0.05 * mu * 2.0 * X)
    whole = -linprog(-about_the_end, A_ub=line_cone(mu, X), b_ub=np.zeros(6), **options).fun
    assert whole == pytest.approx(20.0 * most)


def test_nothing_carries_nothing():
    heel, toe = points_from_wrench(np.zeros(5), 0.1, 0.8)
    np.testing.assert_array_equal([heel, toe], 0.0)
    # Without a normal force nothing else is feasible.
    for e in np.eye(5)[[0, 1, 3, 4]]:
        for sign in (1.0, -1.0):
            assert (line_cone(0.8, 0.1) @ (sign * e)).max() > 0.0


# --- in the world frame ---------------------------------------------------------------------


@given(st.data(), FRICTION, HALF_LENGTH, arrays(float, 3, elements=st.floats(-0.8, 0.8)))
def test_world_cone_is_the_cone_of_a_foot_that_lies_flat(data, mu, X, turn):
    """The same physical wrench, force given in the world, torque in C: (36), (41), (42)."""
    R_WF = Rotation.from_rotvec(turn).as_matrix()
    normal = R_WF[:, 2]
    slope, R_WC = -normal[:2] / normal[2], contact_frame(R_WF)
    w = data.draw(arrays(float, 5, elements=st.floats(-100, 100))) * [1, 1, 1, X, X]
    u = np.concatenate([R_WF @ w[:3], (R_WC.T @ R_WF @ [0.0, *w[3:]])[1:]])
    W = world_cone(line_cone(mu, X), R_WC, slope)
    assert W.shape == (6, 5)
    assert (W @ u).max() == pytest.approx(excess_18(w, mu, X), abs=1e-10 * max(mu, 1.0))


def test_a_foot_that_points_along_y_swaps_the_friction_rows():
    """Turned by a right angle, what limits f_x along the line now limits the world's f_y."""
    mu, X = 0.5, 0.1
    W = world_cone(line_cone(mu, X), Rotation.from_euler("z", np.pi / 2).as_matrix(), LEVEL)
    f_z = 100.0
    along = np.array([0.0, 0.9 * mu * f_z, f_z, 0.0, 0.0])
    assert (W @ along).max() < 0.0
    across = np.array([0.9 * mu * f_z, 0.0, f_z, 0.0, 0.0])
    assert (W @ across).max() < 0.0
    # Across the line a torque about z uses up friction, along it does not.
    torque = np.array([0.0, 0.0, 0.0, 0.0, 0.5 * mu * X * f_z])
    assert (W @ (along + torque)).max() < 0.0
    assert (W @ (across + torque)).max() > 0.0
