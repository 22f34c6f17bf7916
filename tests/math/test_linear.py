"""Compiled linear algebra against LAPACK."""

import numpy as np
import pytest

from drake_linefoot.math import linear


def positive(n, seed):
    A = np.random.default_rng(seed).normal(size=(n, n))
    return A @ A.T + np.eye(n)


@pytest.mark.parametrize("n", [1, 5, 24])
def test_cholesky_and_its_substitutions_invert_the_matrix(n):
    A = positive(n, n)
    L, ok = linear.cholesky(A)
    assert ok
    np.testing.assert_allclose(L, np.linalg.cholesky(A), atol=1e-12)
    B = np.random.default_rng(1).normal(size=(n, 3))
    X = B.copy()
    linear.forward(L, X)
    linear.backward(L, X)
    np.testing.assert_allclose(X, np.linalg.solve(A, B), atol=1e-11)


@pytest.mark.parametrize("bad", [-1.0, 0.0, np.nan])
def test_cholesky_says_when_the_matrix_is_not_positive(bad):
    A = positive(4, 0)
    A[2, 2] = bad
    assert not linear.cholesky(A)[1]
    assert not linear.solve_positive(A, np.eye(4))[1]


def test_solve_positive_is_the_solution():
    A, B = positive(6, 2), np.random.default_rng(3).normal(size=(6, 4))
    X, ok = linear.solve_positive(A, B)
    assert ok
    np.testing.assert_allclose(A @ X, B, atol=1e-11)


@pytest.mark.parametrize("seed", range(5))
def test_orthonormal_rows_of_nearly_dependent_rows(seed):
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(8, 12))
    A[5] = A[1] - 2.0 * A[3] + 1e-4 * A[5]
    Q, R, kept = linear.orthonormal_rows(A, 1e-10)
    assert kept.all()
    np.testing.assert_allclose(Q @ Q.T, np.eye(8), atol=1e-13)
    np.testing.assert_allclose(R @ Q, A, atol=1e-13)
    assert (np.diagonal(R) > 0.0).all()
    np.testing.assert_array_equal(R, np.tril(R))


def test_orthonormal_rows_leave_out_what_depends_on_rows_above():
    A = np.random.default_rng(0).normal(size=(5, 9))
    A[2] = 0.0
    A[4] = 3.0 * A[0] - A[1]
    Q, R, kept = linear.orthonormal_rows(A, 1e-8)
    assert kept.tolist() == [True, True, False, True, False]
    np.testing.assert_array_equal(Q[[2, 4]], 0.0)
    rows = Q[kept]
    np.testing.assert_allclose(rows @ rows.T, np.eye(3), atol=1e-13)
    np.testing.assert_allclose(R @ Q, A, atol=1e-12)


@pytest.mark.parametrize("n", [1, 5, 24])
def test_solve_square_is_the_solution(n):
    """Whatever the units of a row, and where its numbers are: a permutation needs every swap."""
    rng = np.random.default_rng(n)
    for rows in (rng.normal(size=(n, n)) + 2.0 * np.eye(n), np.eye(n)[rng.permutation(n)]):
        A = rows * 10.0 ** rng.uniform(-6.0, 6.0, n)[:, None]
        b = rng.normal(size=n) * np.linalg.norm(A, axis=1)
        before = A.copy(), b.copy()
        x, regular = linear.solve_square(A, b, 1e-3)
        assert regular
        np.testing.assert_allclose(x, np.linalg.solve(A, b), atol=1e-10 * np.abs(x).max())
        np.testing.assert_array_equal(A, before[0])
        np.testing.assert_array_equal(b, before[1])


@pytest.mark.parametrize("row", ["nothing", "nan", "inf", "dependent", "nearly dependent"])
def test_solve_square_refuses_what_is_not_well_conditioned(row):
    A = np.random.default_rng(0).normal(size=(6, 6))
    near = A[0] - 2.0 * A[4] + 1e-5 * A[3]
    rows = {"nothing": 0.0 * near, "nan": np.nan, "inf": np.inf, "dependent": A[0] - A[4]}
    A[3] = rows.get(row, near)
    assert not linear.solve_square(A, np.ones(6), 1e-3)[1]
    if row == "nearly dependent":
        assert linear.solve_square(A, np.ones(6), 1e-7)[1]


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_all_finite_finds_one_that_is_not(bad):
    a = np.full(50, 1e200)  # whose sum of squares is not finite
    assert linear.all_finite(a)
    a[49] = bad
    assert not linear.all_finite(a)
