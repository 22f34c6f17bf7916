"""Small quadratic programs with few active inequalities, solved by guessing which.

The primal-dual active set method: solve with the violated rows as equations, drop rows with a
negative multiplier, add rows that are now violated, until nothing changes. It is exact where
it ends, ends within a few steps when it does, and says so when it does not.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.math.active_set_kernels import few_active

Array = NDArray[np.float64]

STEPS = 8  # more than that and a solver is faster


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
    x, found, positive = few_active(H, g, A, b, tolerance, STEPS)
    if not positive:
        raise np.linalg.LinAlgError("the matrix is not positive definite")
    return x if found else None
