"""Linear algebra of small dense matrices.

Loops, because Numba takes 3 s to compile numpy.linalg.solve for each kind of argument, and has
no triangular solver that works in place. Arguments are never changed unless a function says so.
"""

import math

import numpy as np

from drake_linefoot.math.compiled import compiled
from drake_linefoot.types import Array, Flags


@compiled
def dot(a: Array, b: Array) -> float:
    """Return the inner product of two vectors, shape (n,) each."""
    s = 0.0
    for k in range(len(a)):
        s += a[k] * b[k]
    return s


@compiled
def all_finite(a: Array) -> bool:
    """Return whether every number of a vector, shape (n,), is finite."""
    for k in range(len(a)):
        if not math.isfinite(a[k]):
            return False
    return True


@compiled
def both_finite(a: Array, b: Array) -> bool:
    """Return whether every number of two vectors is finite; one call is faster than two."""
    return all_finite(a) and all_finite(b)


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


@compiled
def orthonormal_rows(A: Array, tolerance: float) -> tuple[Array, Array, Flags]:
    """Return orthonormal rows that span those of A, ``A = R Q``, one after the other.

    Gram-Schmidt, done again where it cancels much, is as accurate as reflections and says
    which row depends on the rows above it: such a row is left out.

    Args:
        A: shape (m, n).
        tolerance: a row that the rows above leave less of than this share depends on them.

    Returns:
        (Q, R, kept): shapes (m, n), lower triangular (m, m) and (m,). A row that is left out is
        0 in Q, and so is its place on the diagonal of R.
    """
    m, n = A.shape
    Q, R = np.zeros((m, n)), np.zeros((m, m))
    columns, share = np.zeros((n, m)), np.empty(m)  # Q again: sums side by side are fast
    kept = np.zeros(m, dtype=np.bool_)
    left = np.empty(n)
    for i in range(m):
        left[:] = A[i]
        size = rest = dot(left, left)
        again = True
        while again:
            before = rest
            share[:i] = 0.0
            for k in range(n):
                for j in range(i):
                    share[j] += left[k] * columns[k, j]
            for j in range(i):
                R[i, j] += share[j]
                for k in range(n):
                    left[k] -= share[j] * Q[j, k]
            rest = dot(left, left)
            again = tolerance * tolerance * size < rest < 0.5 * before  # much was cancelled
        if rest <= tolerance * tolerance * size:
            continue
        R[i, i] = math.sqrt(rest)
        kept[i] = True
        for k in range(n):
            Q[i, k] = columns[k, i] = left[k] / R[i, i]
    return Q, R, kept


@compiled
def solve_positive(A: Array, B: Array) -> tuple[Array, bool]:
    """Return the solution of ``A X = B`` for a symmetric matrix, if that is positive definite.

    Args:
        A: shape (n, n); its lower half is read.
        B: shape (n, m).

    Returns:
        (X, positive): shape (n, m), and whether A is positive definite; X only then.
    """
    X = B.copy()
    L, positive = cholesky(A)
    if positive:
        forward(L, X)
        backward(L, X)
    return X, positive


@compiled
def solve_square(A: Array, b: Array, tolerance: float) -> bool:
    """Solve ``A x = b`` in place: Gaussian elimination, the pivots relative to their rows.

    Args:
        A: shape (n, n); changed.
        b: shape (n,); becomes x.
        tolerance: least pivot over the largest number of its row [-].

    Returns:
        Whether every pivot is above it; b is of no use otherwise.
    """
    n = len(b)
    size = np.empty(n)
    for i in range(n):
        size[i] = 1e-300
        for j in range(n):
            size[i] = max(size[i], abs(A[i, j]))
    for k in range(n):
        best = k
        for i in range(k + 1, n):
            if abs(A[i, k]) * size[best] > abs(A[best, k]) * size[i]:
                best = i
        if abs(A[best, k]) <= tolerance * size[best]:
            return False
        if best != k:
            for j in range(n):
                A[k, j], A[best, j] = A[best, j], A[k, j]
            b[k], b[best] = b[best], b[k]
            size[k], size[best] = size[best], size[k]
        for i in range(k + 1, n):
            f = A[i, k] / A[k, k]
            for j in range(k + 1, n):
                A[i, j] -= f * A[k, j]
            b[i] -= f * b[k]
    for i in range(n - 1, -1, -1):
        for j in range(i + 1, n):
            b[i] -= A[i, j] * b[j]
        b[i] /= A[i, i]
    return True
