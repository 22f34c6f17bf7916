"""Small quadratic programs with few active inequalities, solved by guessing which.

The primal-dual active set method: solve with the violated rows as equations, drop rows with a
negative multiplier, add rows that are now violated, until nothing changes. It is exact where
it ends, ends within a few steps when it does, and says so when it does not.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

Array = NDArray[np.float64]

_STEPS = 8  # more than that and a solver is faster
_NEGATIVE = 1e-12  # [-] of the largest multiplier: what counts as zero


def solve_few_active(H: Array, g: Array, A: Array, b: Array, tolerance: float) -> Array | None:
    """Return the minimum of ``1/2 x'H x + g'x`` subject to ``A x <= b``.

    Args:
        H: symmetric positive definite, shape (n, n).
        g: shape (n,).
        A: shape (m, n).
        b: shape (m,).
        tolerance: by which rows may be violated, in the unit of `b`.

    Returns:
        x of shape (n,), which meets the conditions of optimality; None when it was not found
        or when the active rows depend on each other.

    Raises:
        numpy.linalg.LinAlgError: H is not positive definite.
    """
    L, info = lapack.dpotrf(H, lower=1)
    if info:
        raise np.linalg.LinAlgError(f"dpotrf: {info}: the matrix is not positive definite")
    free = -lapack.dpotrs(L, g, lower=1)[0]
    x, active, seen = free, np.zeros(len(b), dtype=bool), set()
    multipliers = np.zeros(len(b))
    for _ in range(_STEPS):
        violated = A @ x - b > tolerance
        least = -_NEGATIVE * max(1.0, float(multipliers.max(initial=0.0)))
        keep = active & (multipliers > least)
        wanted = keep | violated
        if (wanted == active).all():
            return np.asarray(x, dtype=np.float64)
        key = wanted.tobytes()
        if key in seen:
            return None
        seen.add(key)
        active = wanted
        rows = A[active]
        spread = lapack.dpotrs(L, rows.T, lower=1)[0]
        K, info = lapack.dpotrf(rows @ spread, lower=1)
        if info:
            return None
        found = lapack.dpotrs(K, rows @ free - b[active], lower=1)[0]
        multipliers = np.zeros(len(b))
        multipliers[active] = found
        x = free - spread @ found
    return None
