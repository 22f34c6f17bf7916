"""Discretisation of affine time-varying systems, and elimination of their states.

Most entries of the matrices are zero: products go row by row and leave them out.
"""

import numpy as np

from drake_linefoot.math.compiled import compiled
from drake_linefoot.types import Array, Indices


@compiled
def times(A: Array, X: Array, out: Array, columns: int) -> None:
    """Write the first columns of ``A X``.

    Args:
        A: shape (n, k).
        X: shape (k, m).
        out: shape (n, m), another array.
        columns: how many, at most m; the others stay.
    """
    n, inner = A.shape
    for i in range(n):
        for j in range(columns):
            out[i, j] = 0.0
        for k in range(inner):
            f = A[i, k]
            if f != 0.0:
                for j in range(columns):
                    out[i, j] += f * X[k, j]


@compiled
def times_vector(A: Array, x: Array, out: Array) -> None:
    """Write ``A x``, shapes (n, k) and (k,)."""
    for i in range(len(A)):
        s = 0.0
        for k in range(len(x)):
            s += A[i, k] * x[k]
        out[i] = s


@compiled
def zero_order_hold(
    A: Array, B: Array, c: Array, dt: Array, order: int
) -> tuple[Array, Array, Array]:
    """Discretise ``x' = A x + B u + c`` over steps of length `dt`, (43).

    The exponential series is cut after `order` terms. The centroidal rows of the ECD
    matrix are nilpotent, so they are exact from order 3 on; the rows of eta keep an
    error of order ``(|A| dt)^(order + 1)``.

    Args:
        A: system matrices, shape (K, n, n) [1/s].
        B: input matrices, shape (K, n, m).
        c: affine terms, shape (K, n).
        dt: step lengths [s], shape (K,).
        order: number of terms of the series, at least 1 (1 is explicit Euler).

    Returns:
        (Ad, Bd, cd) with ``x[k+1] = Ad[k] x[k] + Bd[k] u[k] + cd[k]``, same shapes.

    Raises:
        ValueError: `order` is below 1.
    """
    if order < 1:
        raise ValueError("order of a discretisation: must be at least 1")
    K, n, m = B.shape
    Ad, Bd, cd = np.empty((K, n, n)), np.empty((K, n, m)), np.empty((K, n))
    G, AG = np.empty((n, n)), np.empty((n, n))
    for k in range(K):
        # G = dt (I + A dt / 2 (I + A dt / 3 (I + ...))), then Ad = I + A G.
        G[:] = np.eye(n)
        for term in range(order, 1, -1):
            times(A[k], G, AG, n)
            G[:] = AG * (dt[k] / term)
            for i in range(n):
                G[i, i] += 1.0
        G *= dt[k]
        times(A[k], G, Ad[k], n)
        for i in range(n):
            Ad[k, i, i] += 1.0
        times(G, B[k], Bd[k], m)
        times_vector(G, c[k], cd[k])
    return Ad, Bd, cd


@compiled
def condense(
    Ad: Array, Bd: Array, cd: Array, active: Indices, size: int
) -> tuple[Array, Array, Array]:
    """Eliminate the states, ``X = A_qp x0 + B_qp U + C_qp``, (44).

    Args:
        Ad: discrete system matrices, shape (K, n, n).
        Bd: discrete input matrices, shape (K, n, m).
        cd: discrete affine terms, shape (K, n).
        active: blocks of inputs that count, rows (interval, which) in order, shape (b, 2).
        size: inputs in a block.

    Returns:
        (A_qp, B_qp, C_qp) of shapes (K, n, n), (K, n, b size) and (K, n): row k gives x[k+1].
    """
    K, n, _ = Bd.shape
    A_qp, C_qp = np.empty((K, n, n)), np.empty((K, n))
    B_qp = np.zeros((K, n, len(active) * size))
    A_qp[0], C_qp[0] = Ad[0], cd[0]
    block = 0
    for k in range(K):
        if k > 0:
            times(Ad[k], A_qp[k - 1], A_qp[k], n)
            times_vector(Ad[k], C_qp[k - 1], C_qp[k])
            C_qp[k] += cd[k]
            times(Ad[k], B_qp[k - 1], B_qp[k], block * size)
        while block < len(active) and active[block, 0] == k:
            first = active[block, 1] * size
            B_qp[k, :, block * size : (block + 1) * size] = Bd[k, :, first : first + size]
            block += 1
    return A_qp, B_qp, C_qp
