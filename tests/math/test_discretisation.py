"""Zero-order hold against the matrix exponential, condensing against a rollout."""

import numpy as np
import pytest
from scipy.linalg import expm

from drake_linefoot.math.discretisation import condense, condensed_cost, zero_order_hold


def random_system(seed, K=5, n=6, m=3, size=1.0):
    rng = np.random.default_rng(seed)
    A = size * rng.normal(size=(K, n, n))
    return A, rng.normal(size=(K, n, m)), rng.normal(size=(K, n)), rng.uniform(0.005, 0.05, K)


def by_exponential(A, B, c, dt):
    """The discrete matrices from the exponential of [[A, B, c], [0, 0, 0]]."""
    n, m = B.shape
    augmented = np.zeros((n + m + 1, n + m + 1))
    augmented[:n] = np.column_stack([A, B, c])
    E = expm(dt * augmented)[:n]
    return E[:, :n], E[:, n:-1], E[:, -1]


def assert_equal_to_exponential(system, order, atol):
    Ad, Bd, cd = zero_order_hold(*system, order)
    for k, args in enumerate(zip(*system, strict=True)):
        for found, expected in zip((Ad[k], Bd[k], cd[k]), by_exponential(*args), strict=True):
            np.testing.assert_allclose(found, expected, rtol=0, atol=atol)


@pytest.mark.parametrize("seed", range(5))
def test_zero_order_hold_is_the_matrix_exponential(seed):
    """|A dt| is at most about 0.25 here, so the default order 6 leaves 0.25^7 / 7! = 1e-8."""
    assert_equal_to_exponential(random_system(seed), 6, 1e-8)


def test_high_order_is_exact_to_rounding():
    assert_equal_to_exponential(random_system(11, size=2.0), 25, 1e-14)


def test_order_one_is_explicit_euler():
    A, B, c, dt = random_system(12)
    Ad, Bd, cd = zero_order_hold(A, B, c, dt, 1)
    for k, h in enumerate(dt):
        np.testing.assert_allclose(Ad[k], np.eye(6) + h * A[k], rtol=0, atol=1e-15)
        np.testing.assert_allclose(Bd[k], h * B[k], rtol=0, atol=1e-15)
        np.testing.assert_allclose(cd[k], h * c[k], rtol=0, atol=1e-15)


@pytest.mark.parametrize("order", [1, 2, 3, 4, 6])
def test_error_falls_with_the_order_plus_one(order):
    A, B, c, _ = random_system(13, K=1)
    errors = []
    for dt in (0.2, 0.1):
        Ad, _, _ = zero_order_hold(A, B, c, np.array([dt]), order)
        errors.append(np.linalg.norm(Ad[0] - expm(dt * A[0])))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order + 1, abs=0.4)


def test_nilpotent_rows_are_exact():
    """A^3 = 0, as in the centroidal rows of (37): order 3 has every term there is."""
    rng = np.random.default_rng(14)
    A = np.zeros((4, 9, 9))
    A[:, :3, 3:6] = np.eye(3)
    A[:, 6:, :3] = 50.0 * rng.normal(size=(4, 3, 3))
    A = A[:, ::-1, ::-1]  # in any order of the states
    B, c = rng.normal(size=(4, 9, 10)), rng.normal(size=(4, 9))
    system = (A, B, c, np.array([0.01, 0.04, 0.5, 2.0]))
    assert np.abs(A @ A).max() > 0.0
    assert np.abs(A @ A @ A).max() == 0.0
    for order in (3, 4, 6):
        assert_equal_to_exponential(system, order, 1e-12)
    with pytest.raises(AssertionError):
        assert_equal_to_exponential(system, 2, 1e-6)


def test_two_half_steps_are_one_step():
    A, B, c, dt = random_system(15)
    whole = zero_order_hold(A, B, c, dt, 20)
    Ah, Bh, ch = zero_order_hold(A, B, c, 0.5 * dt, 20)
    np.testing.assert_allclose(Ah @ Ah, whole[0], rtol=0, atol=1e-14)
    np.testing.assert_allclose(Ah @ Bh + Bh, whole[1], rtol=0, atol=1e-14)
    twice = np.einsum("kij,kj->ki", Ah, ch) + ch
    np.testing.assert_allclose(twice, whole[2], rtol=0, atol=1e-14)


@pytest.mark.parametrize("order", [0, -1])
def test_order_below_one_is_refused(order):
    with pytest.raises(ValueError, match="order"):
        zero_order_hold(*random_system(16), order)


@pytest.mark.parametrize(("K", "n", "m"), [(1, 4, 2), (7, 6, 3), (16, 12, 10)])
def test_condensing_is_a_rollout(K, n, m):
    rng = np.random.default_rng(K)
    Ad = np.eye(n) + 0.2 * rng.normal(size=(K, n, n))
    Bd, cd = rng.normal(size=(K, n, m)), rng.normal(size=(K, n))
    # Two blocks of inputs in each interval, some of which do not count.
    counts = rng.random((K, 2)) < 0.7
    size, active = m // 2, np.argwhere(counts)
    A_qp, B_qp, C_qp = condense(Ad, Bd, cd, active, size)
    n_u = len(active) * size
    assert (A_qp.shape, B_qp.shape, C_qp.shape) == ((K, n, n), (K, n, n_u), (K, n))
    x0, U = rng.normal(size=n), rng.normal(size=n_u)
    u = np.zeros((K, 2, m // 2))
    u[counts] = U.reshape(-1, size)
    x = x0
    for k in range(K):
        x = Ad[k] @ x + Bd[k, :, : 2 * size] @ u[k].ravel() + cd[k]
        predicted = A_qp[k] @ x0 + B_qp[k] @ U + C_qp[k]
        np.testing.assert_allclose(predicted, x, rtol=1e-11, atol=1e-11)
        later = np.repeat(active[:, 0] > k, size)
        np.testing.assert_array_equal(B_qp[k][:, later], 0.0)


@pytest.mark.parametrize(("K", "n", "m"), [(1, 4, 2), (7, 6, 4), (14, 12, 10)])
def test_the_condensed_cost_is_that_of_the_whole_matrices(K, n, m):
    """(47), (48) without the weights of the inputs; in some intervals no input counts."""
    rng = np.random.default_rng(20 + K)
    Ad = np.eye(n) + 0.2 * rng.normal(size=(K, n, n))
    Bd, cd = rng.normal(size=(K, n, m)), rng.normal(size=(K, n))
    size, active = m // 2, np.argwhere(rng.random((K, 2)) < 0.5)
    _, B_qp, _ = condense(Ad, Bd, cd, active, size)
    L, error = rng.uniform(0.0, 2.0, (K, n)), rng.normal(size=(K, n))
    H, g = condensed_cost(Ad, B_qp, error, L, active, size)
    whole, weights = B_qp.reshape(K * n, -1), np.diag(L.ravel())
    np.testing.assert_allclose(H, 2.0 * whole.T @ weights @ whole, rtol=1e-10, atol=1e-10)
    np.testing.assert_allclose(g, 2.0 * whole.T @ weights @ error.ravel(), rtol=1e-10, atol=1e-10)
    np.testing.assert_array_equal(H, H.T)
