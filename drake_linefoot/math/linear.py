"""Linear systems, with the types the rest of the package uses."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def solve(A: Array, b: Array) -> Array:
    """Return the solution of ``A x = b``; stacks as numpy.linalg.solve has them.

    Args:
        A: shape (..., n, n).
        b: shape (..., n, k), or (n,).

    Raises:
        numpy.linalg.LinAlgError: a matrix is singular.
    """
    return np.asarray(np.linalg.solve(A, b), dtype=np.float64)
