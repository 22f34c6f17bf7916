"""Wrenches from generalized forces: the pseudoinverse, the program (22), contact flags."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import nnls

from drake_linefoot.contact.wrench_cone import line_cone
from drake_linefoot.errors import SolverError
from drake_linefoot.estimation.wrench_estimate import (
    ConstrainedEstimate,
    contact_flags,
    estimate_wrenches,
)
from drake_linefoot.robot.dynamics import robot_dynamics
from drake_linefoot.statuses import Solved
from tests.helpers.cones import wrench_from_points

MU = 0.8
SEEDS = range(6)


def lines_of(humanoid, walking_state, seed):
    """Return Jacobians and contact frames of a random state."""
    context = humanoid.plant.CreateDefaultContext()
    d = robot_dynamics(humanoid, context, walking_state(humanoid, seed))
    return d.J, d.R_WC


def local(wrench, R_WC):
    """Return wrenches with their forces in the contact frames."""
    return np.array([[*(R.T @ w[:3]), *w[3:]] for w, R in zip(wrench, R_WC, strict=True)])


def feasible_wrenches(rng, R_WC, X, margin=1.0):
    """Wrenches of random point forces, of which the friction uses a part."""
    out = []
    for R in R_WC:
        f_z = rng.uniform(20.0, 150.0, 2)
        sides = margin * MU * f_z[:, None] * rng.uniform(-1.0, 1.0, (2, 2))
        w = wrench_from_points(*np.column_stack([sides, f_z]), X)
        out.append([*(R @ w[:3]), *w[3:]])
    return np.array(out)


def generalized(J, wrench):
    return np.einsum("fij,fi->j", J, wrench)


@pytest.fixture
def constrained(humanoid):
    return ConstrainedEstimate(humanoid.mass, humanoid.contact)


@pytest.mark.parametrize("seed", SEEDS)
def test_pseudoinverse_is_exact_for_forces_of_the_feet(humanoid, walking_state, seed):
    J, _ = lines_of(humanoid, walking_state, seed)
    wrench = 100.0 * np.random.default_rng(seed).normal(size=(2, 5))
    found = estimate_wrenches(generalized(J, wrench), J)
    np.testing.assert_allclose(found, wrench, rtol=0, atol=1e-9)


@pytest.mark.parametrize("seed", SEEDS)
def test_pseudoinverse_is_the_least_squares_solution(humanoid, walking_state, seed):
    """For a residual that no pair of feet can give."""
    J, _ = lines_of(humanoid, walking_state, seed)
    residual = 50.0 * np.random.default_rng(seed).normal(size=humanoid.nv)
    expected = np.linalg.lstsq(J.reshape(10, -1).T, residual, rcond=None)[0]
    found = estimate_wrenches(residual, J)
    np.testing.assert_allclose(found.ravel(), expected, rtol=0, atol=1e-9)


def test_pseudoinverse_with_a_foot_that_cannot_be_seen(humanoid, walking_state):
    """A Jacobian without full rank: the other foot is right, this one gets nothing."""
    J, _ = lines_of(humanoid, walking_state, 0)
    J[1] = 0.0
    wrench = 100.0 * np.random.default_rng(0).normal(size=(2, 5))
    found = estimate_wrenches(generalized(J, wrench), J)
    np.testing.assert_allclose(found[0], wrench[0], rtol=0, atol=1e-9)
    np.testing.assert_allclose(found[1], 0.0, rtol=0, atol=1e-12)


@pytest.mark.parametrize("seed", SEEDS)
def test_inside_the_cone_both_forms_agree(humanoid, walking_state, constrained, seed):
    J, R_WC = lines_of(humanoid, walking_state, seed)
    rng = np.random.default_rng(seed)
    wrench = feasible_wrenches(rng, R_WC, humanoid.half_length, margin=0.6)
    found = constrained.solve(generalized(J, wrench), J, R_WC, MU)
    np.testing.assert_allclose(found, wrench, rtol=0, atol=1e-3)
    plain = estimate_wrenches(generalized(J, wrench), J)
    np.testing.assert_allclose(found, plain, rtol=0, atol=1e-3)


@pytest.mark.parametrize("seed", SEEDS)
def test_outside_the_cone_it_is_the_best_pair_of_feasible_wrenches(
    humanoid, walking_state, constrained, seed
):
    """Least squares over nonnegative amounts of the edges of all four friction pyramids."""
    J, R_WC = lines_of(humanoid, walking_state, seed)
    X = humanoid.half_length
    rng = np.random.default_rng(seed)
    wrench = feasible_wrenches(rng, R_WC, X) + rng.normal(size=(2, 5)) * [150, 150, 80, 5, 15]
    residual = generalized(J, wrench)
    found = constrained.solve(residual, J, R_WC, MU)
    plain = estimate_wrenches(residual, J)
    W, weight = line_cone(MU, X), humanoid.mass * 9.81
    assert (W @ local(plain, R_WC).T).max() > 1.0  # there is something to do
    assert (W @ local(found, R_WC).T).max() < 1e-6 * weight

    edges = [(sx * MU, sy * MU, 1.0) for sx in (-1, 1) for sy in (-1, 1)]
    rays = [wrench_from_points(f, np.zeros(3), X) for f in edges]
    rays += [wrench_from_points(np.zeros(3), f, X) for f in edges]
    columns = [J[side].T @ [*(R_WC[side] @ ray[:3]), *ray[3:]] for side in (0, 1) for ray in rays]
    best = nnls(np.array(columns).T, residual, maxiter=1000)[1]
    error = np.linalg.norm(residual - generalized(J, found))
    assert error == pytest.approx(best, rel=1e-5)


def test_pulling_feet_get_no_force(humanoid, walking_state, constrained):
    J, R_WC = lines_of(humanoid, walking_state, 1)
    pull = np.zeros((2, 5))
    pull[:, 2] = -100.0
    found = constrained.solve(generalized(J, pull), J, R_WC, MU)
    assert np.all(found[:, 2] < 100.0)
    assert (line_cone(MU, humanoid.half_length) @ local(found, R_WC).T).max() < 1e-3


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_program_that_is_not_solved_is_an_error(humanoid, walking_state, constrained, bad):
    J, R_WC = lines_of(humanoid, walking_state, 2)
    residual = np.zeros(humanoid.nv)
    residual[7] = bad
    with np.errstate(invalid="ignore"), pytest.raises(SolverError, match="contact") as caught:
        constrained.solve(residual, J, R_WC, MU)
    assert caught.value.program == "contact"
    assert caught.value.status == Solved.NOT_FINITE.words
    wrench = feasible_wrenches(np.random.default_rng(0), R_WC, humanoid.half_length, 0.5)
    found = constrained.solve(generalized(J, wrench), J, R_WC, MU)  # it recovers
    np.testing.assert_allclose(found, wrench, rtol=0, atol=1e-3)


# --- contact flags --------------------------------------------------------------------------


def flags_of(force, before):
    flags = contact_flags(np.array(force), np.array(before, dtype=float), 50.0, 20.0)
    assert set(flags) <= {0.0, 1.0}
    return tuple((flags > 0.5).tolist())


@pytest.mark.parametrize(
    ("force", "before", "after"),
    [
        ((60.0, 60.0), (False, False), (True, True)),
        ((40.0, 40.0), (False, False), (False, False)),  # between the two: as before
        ((40.0, 40.0), (True, True), (True, True)),
        ((10.0, 60.0), (True, False), (False, True)),
        ((50.0, 20.0), (False, True), (False, False)),  # both are limits to exceed
        ((-30.0, 1e3), (True, True), (False, True)),
    ],
)
def test_contact_flags_have_hysteresis(force, before, after):
    assert flags_of(force, before) == after


@given(st.lists(st.floats(-50.0, 150.0), min_size=1, max_size=30))
def test_a_foot_changes_only_beyond_its_limits(forces):
    """Along any course of forces, feet are independent and flip at the right limit."""
    left = right = False
    for force in forces:
        was = left
        left, right = flags_of((force, 0.0), (left, right))
        assert right is False
        assert isinstance(left, bool)
        if left and not was:
            assert force > 50.0
        if was and not left:
            assert force <= 20.0
        if force > 50.0:
            assert left
        if force <= 20.0:
            assert not left
