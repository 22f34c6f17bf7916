"""Compiled active-set method of small quadratic programs."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.kernels import backward, cholesky, dot, forward

Array = NDArray[np.float64]


@compiled
def rest(A: Array, x: Array, b: Array) -> Array:
    """Return ``A x - b``.

    Args:
        A: shape (m, n).
        x: shape (n,).
        b: shape (m,).
    """
    out = -b
    for i in range(len(b)):
        for j in range(len(x)):
            out[i] += A[i, j] * x[j]
    return out


@compiled
def on_rows(
    L: Array, free: Array, A: Array, b: Array, active: NDArray[np.bool_]
) -> tuple[Array, Array, bool]:
    """Minimise a quadratic form with some rows of ``A x = b`` as equations.

    Args:
        L: lower factor of the form, shape (n, n).
        free: its minimum without rows, shape (n,).
        A: shape (m, n).
        b: shape (m,).
        active: which rows, shape (m,).

    Returns:
        (x, multipliers, independent): shapes (n,) and (m,), and whether these rows are.
    """
    rows = np.flatnonzero(active)
    count, n = len(rows), len(free)
    x, multipliers = free.copy(), np.zeros(len(b))
    spread = A[rows].T.copy()
    forward(L, spread)
    backward(L, spread)
    K, found = np.zeros((count, count)), np.empty((count, 1))
    for i in range(count):
        found[i, 0] = dot(A[rows[i]], free) - b[rows[i]]
        for k in range(n):
            f = A[rows[i], k]
            for j in range(count):
                K[i, j] += f * spread[k, j]
    L_K, independent = cholesky(K)
    if independent:
        forward(L_K, found)
        backward(L_K, found)
        for i in range(count):
            multipliers[rows[i]] = found[i, 0]
            for k in range(n):
                x[k] -= spread[k, i] * found[i, 0]
    return x, multipliers, independent


@compiled
def few_active(
    H: Array, g: Array, A: Array, b: Array, tolerance: float, steps: int
) -> tuple[Array, bool, bool]:
    """Minimise ``1/2 x'H x + g'x`` subject to ``A x <= b``; see `active_set.solve_few_active`.

    Args:
        H: symmetric, shape (n, n).
        g: shape (n,).
        A: shape (m, n).
        b: shape (m,).
        tolerance: by which rows may be violated, in the unit of `b`.
        steps: guesses of the active rows.

    Returns:
        (x, found, positive): shape (n,), whether it is the minimum, and whether H is positive
        definite.
    """
    n, m = len(g), len(b)
    free = np.empty((n, 1))
    free[:, 0] = -g
    L, positive = cholesky(H)
    if not positive:
        return free[:, 0], False, False
    forward(L, free)
    backward(L, free)
    x = free[:, 0].copy()
    active, seen = np.zeros(m, dtype=np.bool_), np.zeros((steps, m), dtype=np.bool_)
    multipliers = np.zeros(m)
    for step in range(steps):
        least = -1e-12 * max(1.0, multipliers.max())  # what counts as zero
        wanted = (active & (multipliers > least)) | (rest(A, x, b) > tolerance)
        if (wanted == active).all():
            return x, True, True
        for before in range(step):
            if (seen[before] == wanted).all():
                return x, False, True
        seen[step] = wanted
        active = wanted
        x, multipliers, independent = on_rows(L, free[:, 0], A, b, active)
        if not independent:
            return x, False, True
    return x, False, True
