"""Compiled matrices of the MPC: the linearised ECD and the cost of the condensed program."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.math import kernels
from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.discretisation_kernels import times, times_vector

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@compiled
def add_skew(factor: float, a: Array, out: Array) -> None:
    """Add a multiple of the matrix of the cross product with `a` to `out`, shape (3, 3)."""
    out[0, 1] -= factor * a[2]
    out[0, 2] += factor * a[1]
    out[1, 0] += factor * a[2]
    out[1, 2] -= factor * a[0]
    out[2, 0] -= factor * a[1]
    out[2, 1] += factor * a[0]


@compiled
def orientation_terms(
    I_B: Array,
    R_d: Array,
    Omega_d: Array,
    L_d: Array,
    r_d: Array,
    v_d: Array,
    r_G: Array,
    m: float,
) -> tuple[Array, Array, Array, Array, Array]:
    """Return a_0 ... a_4 of (31); arguments as in `ecd_model.Linearisation`, for K intervals.

    Where the inertia is not positive definite, they are not finite.

    Args:
        I_B: shape (K, 3, 3).
        R_d: shape (K, 3, 3).
        Omega_d: shape (K, 3).
        L_d: shape (K, 3).
        r_d: shape (K, 3).
        v_d: shape (K, 3).
        r_G: fixed point of L_G [m], shape (3,).
        m: mass [kg].

    Returns:
        (a0, a1, a2, a3, a4): shapes (K, 3) and four times (K, 3, 3).
    """
    K = len(r_d)
    a0, a1, a2 = np.empty((K, 3)), np.empty((K, 3, 3)), np.empty((K, 3, 3))
    a3, a4 = np.empty((K, 3, 3)), np.empty((K, 3, 3))
    momentum, S, right = np.empty(3), np.empty((3, 3)), np.empty((3, 6))
    for k in range(K):
        R, L, r, v = R_d[k], L_d[k], r_d[k], v_d[k]
        right[:] = 0.0
        for i in range(3):
            for j in range(3):
                right[i, j] = R[j, i]
        L_B = R[0] * L[0] + R[1] * L[1] + R[2] * L[2]
        add_skew(1.0, L_B, right[:, 3:])
        factor, positive = kernels.cholesky(I_B[k])
        if not positive:
            right[:] = np.nan
        else:
            kernels.forward(factor, right)
            kernels.backward(factor, right)
        a3[k], a4[k] = right[:, :3], right[:, 3:]
        add_skew(-1.0, Omega_d[k], a4[k])
        momentum[0] = m * (r[1] * v[2] - r[2] * v[1]) - L[0]
        momentum[1] = m * (r[2] * v[0] - r[0] * v[2]) - L[1]
        momentum[2] = m * (r[0] * v[1] - r[1] * v[0]) - L[2]
        times_vector(a3[k], momentum, a0[k])
        S[:] = 0.0
        add_skew(m, v, S)
        times(a3[k], S, a1[k], 3)
        S[:] = 0.0
        add_skew(-m, r - r_G, S)
        times(a3[k], S, a2[k], 3)
    return a0, a1, a2, a3, a4


@compiled
def system_matrices(
    a0: Array, a1: Array, a2: Array, a3: Array, a4: Array, r_G: Array, m: float, gravity: Array
) -> tuple[Array, Array]:
    """Return A(t) of (37) and C(t) of (39).

    Args:
        a0: of `orientation_terms`, shape (K, 3).
        a1: shape (K, 3, 3), and so the next three.
        a2: see `a1`.
        a3: see `a1`.
        a4: see `a1`.
        r_G: fixed point of L_G [m], shape (3,).
        m: mass [kg].
        gravity: [m/s^2], shape (3,).

    Returns:
        (A, C) of shapes (K, 12, 12) and (K, 12).
    """
    K = len(a0)
    A, C = np.zeros((K, 12, 12)), np.zeros((K, 12))
    for k in range(K):
        for i in range(3):
            A[k, i, 3 + i] = 1.0
            C[k, 3 + i] = gravity[i]
            C[k, 9 + i] = a0[k, i]
        add_skew(-m, gravity, A[k, 6:9, :3])
        C[k, 6] = -m * (r_G[1] * gravity[2] - r_G[2] * gravity[1])
        C[k, 7] = -m * (r_G[2] * gravity[0] - r_G[0] * gravity[2])
        C[k, 8] = -m * (r_G[0] * gravity[1] - r_G[1] * gravity[0])
        A[k, 9:, :3], A[k, 9:, 3:6], A[k, 9:, 6:9], A[k, 9:, 9:] = a1[k], a2[k], a3[k], a4[k]
    return A, C


@compiled
def input_matrices(p_WC: Array, R_WC: Array, r_G: Array, m: float) -> Array:
    """Return B(t) of (38), shape (K, 12, 10).

    Args:
        p_WC: contact lines [m], shape (K, 2, 3).
        R_WC: contact frames, shape (K, 2, 3, 3).
        r_G: fixed point of L_G [m], shape (3,).
        m: mass [kg].
    """
    K = len(p_WC)
    B = np.zeros((K, 12, 10))
    for k in range(K):
        for foot in range(2):
            first = 5 * foot
            for i in range(3):
                B[k, 3 + i, first + i] = 1.0 / m
                for j in range(2):
                    B[k, 6 + i, first + 3 + j] = R_WC[k, foot, i, 1 + j]
            add_skew(1.0, p_WC[k, foot] - r_G, B[k, 6:9, first : first + 3])
    return B


@compiled
def cost_matrices(
    Ad: Array,
    B_qp: Array,
    error: Array,
    L: Array,
    K: Array,
    active: Indices,
    scale: Array,
    cost_scale: float,
) -> tuple[Array, Array]:
    """Return the cost in scaled inputs, (47) and (48).

    An input acts on the states from its interval on. What those count for is found backwards,
    ``P_k = L_k + Ad_{k+1}' P_{k+1} Ad_{k+1}`` and likewise for the error, so that a block of
    the sum is one product at the later of its two intervals.

    Args:
        Ad: discrete system matrices, shape (K, n, n).
        B_qp: condensed inputs, shape (K, n, b size).
        error: of the states without inputs, shape (K, n).
        L: weights of the states, shape (K, n).
        K: weights of the inputs, shape (b size,).
        active: blocks of inputs, rows (interval, which) in order, shape (b, 2).
        scale: unit of each input, shape (b size,).
        cost_scale: what the cost is divided by.

    Returns:
        (H, g) of shapes (b size, b size) and (b size,).
    """
    count, n, total = B_qp.shape
    size = total // max(len(active), 1)
    H, g = np.empty((total, total)), np.empty(total)
    P, half, slope, PB = np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, 1)), np.empty((n, size))
    block = len(active) - 1
    for k in range(count - 1, -1, -1):
        if k < count - 1:
            times(Ad[k + 1].T, P, half, n)
            times(Ad[k + 1].T, half.T.copy(), P, n)
            times(Ad[k + 1].T, slope.copy(), slope, 1)
        for i in range(n):
            P[i, i] += L[k, i]
            slope[i, 0] += L[k, i] * error[k, i]
        while block >= 0 and active[block, 0] == k:
            first, end = block * size, (block + 1) * size
            B = B_qp[k, :, first:end].copy()
            times(P, B, PB, size)
            times(PB.T, B_qp[k], H[first:end], end)
            times(B.T, slope, g[first:end].reshape(size, 1), 1)
            block -= 1
    for i in range(total):
        H[i, i] += K[i]
    for i in range(total):
        factor = 2.0 * scale[i] / cost_scale
        g[i] *= factor
        for j in range(i + 1):
            H[i, j] *= factor * scale[j]
            H[j, i] = H[i, j]
    return H, g
