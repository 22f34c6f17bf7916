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
    m, n = A.shape
    x, multipliers, rows, count = free.copy(), np.zeros(m), np.empty(m, dtype=np.int64), 0
    for i in range(m):
        if active[i]:
            rows[count] = i
            count += 1
    response = np.empty((n, count))
    for i in range(count):
        for k in range(n):
            response[k, i] = A[rows[i], k]
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
def same(a: Flags, b: Flags) -> bool:
    """Return whether two rows of flags are the same, shape (m,) each."""
    for i in range(len(a)):
        if a[i] != b[i]:
            return False
    return True


@compiled
def next_guess(
    violated: Array, multipliers: Array, tolerance: float, active: Flags, guess: Flags
) -> bool:
    """Write which rows seem active; return whether they are those that were.

    Args:
        violated: by how much rows are, see `violation`, shape (m,).
        multipliers: of the active rows, 0 for others, shape (m,).
        tolerance: by which rows may be violated.
        active: rows that were equations, shape (m,).
        guess: written, shape (m,).
    """
    largest, settled = 1.0, True
    for i in range(len(violated)):
        largest = max(largest, multipliers[i])
    for i in range(len(violated)):
        stays = active[i] and multipliers[i] > -1e-12 * largest  # what counts as zero
        guess[i] = stays or violated[i] > tolerance
        settled = settled and guess[i] == active[i]
    return settled


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
    column, free = np.empty((n, 1)), np.empty(n)
    for i in range(n):
        column[i, 0] = free[i] = -g[i]
    L, positive = cholesky(H)
    if not positive or n == 0:
        return free, positive
    forward(L, column)
    backward(L, column)
    for i in range(n):
        free[i] = column[i, 0]
    x, multipliers, seen = free, np.zeros(m), np.zeros((STEPS + 1, m), dtype=np.bool_)
    for step in range(STEPS):  # row `step` of `seen` is what was active
        violated, guess = violation(A, x, b), seen[step + 1]
        if next_guess(violated, multipliers, tolerance, seen[step], guess):
            return x, True
        for before in range(1, step):
            if same(seen[before], guess):
                return x, False
        x, multipliers, independent = on_rows(L, free, A, b, guess)
        if not independent:
            return x, False
    return x, False
