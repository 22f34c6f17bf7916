"""Small quadratic programs with few active inequalities, solved by guessing which.

The primal-dual active set method: solve with the violated rows as equations, drop rows with a
negative multiplier, add rows that are now violated, until nothing changes. It is exact where
it ends, ends within a few steps when it does, and says so when it does not.
"""

import numpy as np

from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.linear import backward, cholesky, dot, forward
from drake_linefoot.types import Array, Flags

STEPS = 8  # guesses of the active rows; where it takes more, a solver is faster


@compiled
def violation(A: Array, x: Array, b: Array) -> Array:
    """Return ``A x - b``, by which the rows ``A x <= b`` are violated.

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
def on_rows(L: Array, free: Array, A: Array, b: Array, active: Flags) -> tuple[Array, Array, bool]:
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
    response = A[rows].T.copy()
    forward(L, response)
    backward(L, response)
    K, found = np.zeros((count, count)), np.empty((count, 1))
    for i in range(count):
        found[i, 0] = dot(A[rows[i]], free) - b[rows[i]]
        for k in range(n):
            f = A[rows[i], k]
            for j in range(count):
                K[i, j] += f * response[k, j]
    L_K, independent = cholesky(K)
    if independent:
        forward(L_K, found)
        backward(L_K, found)
        for i in range(count):
            multipliers[rows[i]] = found[i, 0]
            for k in range(n):
                x[k] -= response[k, i] * found[i, 0]
    return x, multipliers, independent


@compiled
def solve_few_active(
    H: Array, g: Array, A: Array, b: Array, tolerance: float
) -> tuple[Array, bool]:
    """Minimise ``1/2 x'H x + g'x`` subject to ``A x <= b``.

    Args:
        H: symmetric, shape (n, n).
        g: shape (n,).
        A: shape (m, n).
        b: shape (m,).
        tolerance: by which rows may be violated, in the unit of `b`.

    Returns:
        (x, found): shape (n,), and whether it meets the conditions of optimality; it does not
        when H is not positive definite, when the active rows depend on each other, or when
        `STEPS` guesses were not enough.
    """
    n, m = len(g), len(b)
    column = -g.reshape(n, 1)
    x = free = column.reshape(n)
    L, positive = cholesky(H)
    if not positive or n == 0:
        return x, positive
    forward(L, column)
    backward(L, column)
    active, seen = np.zeros(m, dtype=np.bool_), np.zeros((STEPS, m), dtype=np.bool_)
    multipliers = np.zeros(m)
    for step in range(STEPS):
        least = -1e-12 * max(1.0, multipliers.max())  # what counts as zero
        guess = (active & (multipliers > least)) | (violation(A, x, b) > tolerance)
        if (guess == active).all():
            return x, True
        for before in range(step):
            if (seen[before] == guess).all():
                return x, False
        seen[step] = guess
        active = guess
        x, multipliers, independent = on_rows(L, free, A, b, active)
        if not independent:
            return x, False
    return x, False
