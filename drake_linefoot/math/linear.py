"""Linear systems, with the types the rest of the package uses."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

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


def solve_positive(A: Array, b: Array) -> Array:
    """Return the solution of ``A x = b`` for a symmetric positive definite matrix.

    One call of LAPACK, without the overhead that counts for small matrices.

    Args:
        A: shape (n, n); its lower half is read.
        b: shape (n,) or (n, k).

    Raises:
        numpy.linalg.LinAlgError: the matrix is not positive definite.
    """
    _, x, info = lapack.dposv(A, b, lower=1)
    if info:
        raise np.linalg.LinAlgError(f"dposv: {info}: the matrix is not positive definite")
    return np.asarray(x, dtype=np.float64)
