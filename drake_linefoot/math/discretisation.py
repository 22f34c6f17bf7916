"""Discretisation of affine time-varying systems, and elimination of their states.

Most entries of the matrices are zero: products go row by row and leave them out.
"""

import numpy as np

from drake_linefoot.math.compiled import compiled, inlined
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
def transposed_times(A: Array, X: Array, out: Array) -> None:
    """Write ``A' X``.

    Args:
        A: shape (k, n).
        X: shape (k, m).
        out: shape (n, m), another array.
    """
    inner, n = A.shape
    out[:] = 0.0
    for k in range(inner):
        for i in range(n):
            f = A[k, i]
            if f != 0.0:
                for j in range(X.shape[1]):
                    out[i, j] += f * X[k, j]


@inlined
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
        for i in range(n):
            for j in range(n):
                G[i, j] = 1.0 if i == j else 0.0
        for term in range(order, 0, -1):
            if term > 1:
                times(A[k], G, AG, n)
            for i in range(n):
                for j in range(n):
                    if term > 1:
                        G[i, j] = AG[i, j] * (dt[k] / term) + (1.0 if i == j else 0.0)
                    else:
                        G[i, j] *= dt[k]
        times(A[k], G, Ad[k], n)
        for i in range(n):
            Ad[k, i, i] += 1.0
        times(G, B[k], Bd[k], m)
        times_vector(G, c[k], cd[k])
    return Ad, Bd, cd


@inlined
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
    block = 0
    for k in range(K):
        if k == 0:
            for i in range(n):
                C_qp[0, i] = cd[0, i]
                for j in range(n):
                    A_qp[0, i, j] = Ad[0, i, j]
        else:
            times(Ad[k], A_qp[k - 1], A_qp[k], n)
            times_vector(Ad[k], C_qp[k - 1], C_qp[k])
            for i in range(n):
                C_qp[k, i] += cd[k, i]
            times(Ad[k], B_qp[k - 1], B_qp[k], block * size)
        while block < len(active) and active[block, 0] == k:
            first = active[block, 1] * size
            for i in range(n):
                for j in range(size):
                    B_qp[k, i, block * size + j] = Bd[k, i, first + j]
            block += 1
    return A_qp, B_qp, C_qp


@compiled
def cost_of_input(P: Array, B: Array, row: int, H: Array) -> None:
    """Write ``B' P B`` of one input with all up to it, as a row and a column.

    Args:
        P: symmetric, shape (n, n).
        B: shape (n, m).
        row: of the input.
        H: shape (m, m).
    """
    n = len(P)
    for column in range(row + 1):
        H[row, column] = 0.0
    for i in range(n):
        f = 0.0
        for j in range(n):
            f += P[i, j] * B[j, row]
        for column in range(row + 1):
            H[row, column] += f * B[i, column]
    for column in range(row):
        H[column, row] = H[row, column]


@inlined
def condensed_cost(
    Ad: Array, B_qp: Array, error: Array, L: Array, active: Indices, size: int
) -> tuple[Array, Array]:
    """Return ``2 B'L B`` of (47) and ``2 B'L error`` of (48).

    Backwards in time: ``P_k = L_k + Ad[k+1]' P_k+1 Ad[k+1]`` is what x[k+1] costs from then on when
    no input follows, so that inputs of interval k cost ``B_k' P_k B_k`` with all up to them. That
    is one product for each interval instead of one for each that follows it.

    Args:
        Ad: discrete system matrices, shape (K, n, n).
        B_qp: condensed inputs, shape (K, n, b size), see `condense`.
        error: of the states without inputs, shape (K, n).
        L: weights of the states, shape (K, n).
        active: see `condense`.
        size: likewise.

    Returns:
        (H, g) of shapes (b size, b size) and (b size,).
    """
    K, n, count = B_qp.shape
    H, g = np.empty((count, count)), np.zeros(count)
    P, half = np.zeros((n, n)), np.empty((n, n))  # P is twice that of above
    slope, after = np.zeros(n), np.empty(n)
    last = count
    for k in range(K - 1, -1, -1):
        if k < K - 1:
            for i in range(n):
                after[i] = slope[i]
            transposed_times(Ad[k + 1], P, half)
            times(half, Ad[k + 1], P, n)
            for i in range(n):
                slope[i] = 0.0
                for j in range(n):
                    slope[i] += Ad[k + 1, j, i] * after[j]
        for i in range(n):
            P[i, i] += 2.0 * L[k, i]
            slope[i] += 2.0 * L[k, i] * error[k, i]
        first = last
        while first > 0 and active[first // size - 1, 0] == k:
            first -= size
        for row in range(first, last):
            cost_of_input(P, B_qp[k], row, H)
            for i in range(n):
                g[row] += slope[i] * B_qp[k, i, row]
        last = first
    return H, g
