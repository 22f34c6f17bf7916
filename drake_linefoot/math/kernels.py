"""Compiled linear algebra of small dense matrices.

For matrices of a few dozen rows, a loop is faster than LAPACK with its checks and copies.
Arguments are never changed unless a function says so.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.math.compiled import compiled

Array = NDArray[np.float64]


@compiled
def cholesky(A: Array) -> tuple[Array, bool]:
    """Return the lower factor of a symmetric matrix, ``A = L L'``, and whether there is one.

    Args:
        A: shape (n, n); its lower half is read.

    Returns:
        (L, positive): shape (n, n), zero above the diagonal.
    """
    n = len(A)
    L = np.zeros((n, n))
    for i in range(n):
        for j in range(i):
            s = A[i, j]
            for k in range(j):
                s -= L[i, k] * L[j, k]
            L[i, j] = s / L[j, j]
        s = A[i, i]
        for k in range(i):
            s -= L[i, k] * L[i, k]
        if not s > 0.0:
            return L, False
        L[i, i] = math.sqrt(s)
    return L, True


@compiled
def forward(L: Array, B: Array) -> None:
    """Solve ``L X = B`` for a lower triangular L, in place of B.

    Args:
        L: shape (n, n).
        B: shape (n, m); becomes X.
    """
    n, m = B.shape
    for i in range(n):
        for k in range(i):
            f = L[i, k]
            if f != 0.0:
                for j in range(m):
                    B[i, j] -= f * B[k, j]
        f = 1.0 / L[i, i]
        for j in range(m):
            B[i, j] *= f


@compiled
def backward(L: Array, B: Array) -> None:
    """Solve ``L' X = B`` for a lower triangular L, in place of B.

    Args:
        L: shape (n, n).
        B: shape (n, m); becomes X.
    """
    n, m = B.shape
    for i in range(n - 1, -1, -1):
        f = 1.0 / L[i, i]
        for j in range(m):
            B[i, j] *= f
        for k in range(i):
            f = L[i, k]
            if f != 0.0:
                for j in range(m):
                    B[k, j] -= f * B[i, j]
