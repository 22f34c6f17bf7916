"""Programs with few active rows: conditions of optimality, and a solver for comparison."""

import numpy as np
import pytest
from pydrake.solvers import ClarabelSolver, MathematicalProgram

from drake_linefoot.math.active_set import solve_few_active

TOLERANCE = 1e-10


def program(seed, n=6, m=6):
    """A strictly convex program whose bounds hold at 0."""
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(n, n))
    H = root @ root.T + 0.1 * np.eye(n)
    return H, rng.normal(size=n), rng.normal(size=(m, n)), rng.uniform(0.0, 2.0, m)


SEEDS = [s for s in range(40) if solve_few_active(*program(s), TOLERANCE)[1]]


@pytest.mark.parametrize("seed", SEEDS)
def test_what_is_found_is_the_minimum(seed):
    H, g, A, b = program(seed)
    x, _ = solve_few_active(H, g, A, b, TOLERANCE)
    assert (A @ x <= b + TOLERANCE).all()
    active = A @ x >= b - 1e-8
    # The gradient is a combination of active rows with multipliers that are not negative.
    multipliers = np.linalg.lstsq(A[active].T, -(H @ x + g), rcond=None)[0]
    np.testing.assert_allclose(A[active].T @ multipliers, -(H @ x + g), rtol=0, atol=1e-7)
    assert (multipliers >= -1e-8).all()
    prog = MathematicalProgram()
    z = prog.NewContinuousVariables(len(g))
    prog.AddQuadraticCost(H, g, z, True)
    prog.AddLinearConstraint(A, np.full(len(b), -np.inf), b, z)
    np.testing.assert_allclose(ClarabelSolver().Solve(prog).GetSolution(z), x, atol=1e-5)


def test_most_programs_are_solved():
    assert len(SEEDS) >= 36  # of 40


def test_without_an_active_row_it_is_the_free_minimum():
    H, g, A, b = program(0)
    x, _ = solve_few_active(H, g, A, b + 1e3, TOLERANCE)
    np.testing.assert_allclose(H @ x, -g, rtol=0, atol=1e-12)


def test_rows_that_depend_on_each_other_are_left_to_a_solver():
    H, g = np.eye(2), np.array([-1.0, 0.0])
    A = np.array([[1.0, 0.0], [1.0, 0.0]])
    assert not solve_few_active(H, g, A, np.array([0.5, 0.5]), TOLERANCE)[1]


def test_a_cost_that_is_not_convex_is_refused():
    assert not solve_few_active(-np.eye(2), np.ones(2), np.eye(2), np.ones(2), TOLERANCE)[1]


def test_a_program_without_unknowns_is_solved():
    nothing = np.zeros((0, 0))
    x, found = solve_few_active(nothing, np.zeros(0), nothing, np.zeros(0), TOLERANCE)
    assert (x.shape, found) == ((0,), True)
