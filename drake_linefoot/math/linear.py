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
def copy(source: Array, to: Array) -> None:
    """Write one array of three axes into another; quicker to compile than ``to[:] = source``."""
    for k in range(source.shape[0]):
        for i in range(source.shape[1]):
            for j in range(source.shape[2]):
                to[k, i, j] = source[k, i, j]


@compiled
def cholesky(A: Array) -> tuple[Array, bool]:
    """Return the lower factor of a symmetric matrix, ``A = L L'``, and whether there is one.

    Args:
        A: shape (n, n); its lower half is read.

    Returns:
        (L, positive): shape (n, n), zero above the diagonal.
    """
    n = len(A)
    L, U = np.zeros((n, n)), np.empty((n, n))  # U is L' so far: its rows lie side by side
    for i in range(n):
        for j in range(i, n):
            U[i, j] = A[j, i]
    for k in range(n):
        if not U[k, k] > 0.0:
            return L, False
        L[k, k] = math.sqrt(U[k, k])
        for j in range(k + 1, n):
            U[k, j] /= L[k, k]
            L[j, k] = U[k, j]
        for i in range(k + 1, n):
            f = U[k, i]
            for j in range(i, n):
                U[i, j] -= f * U[k, j]
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
def eliminate(U: Array, least: float) -> bool:
    """Make the first n columns upper triangular, by rows with the largest pivot of each column.

    Args:
        U: shape (n, m), m >= n; changed in place.
        least: what the size of every pivot must exceed.

    Returns:
        Whether they all do; else it ends with the first that does not.
    """
    n, m = U.shape
    for k in range(n):
        pivot = k
        for i in range(k + 1, n):
            if abs(U[i, k]) > abs(U[pivot, k]):
                pivot = i
        if not abs(U[pivot, k]) > least:
            return False
        if pivot != k:
            for j in range(k, m):
                U[k, j], U[pivot, j] = U[pivot, j], U[k, j]
        for i in range(k + 1, n):
            f = U[i, k] / U[k, k]
            if f != 0.0:
                for j in range(k + 1, m):
                    U[i, j] -= f * U[k, j]
    return True


@compiled
def solve_square(A: Array, b: Array, least: float) -> tuple[Array, bool]:
    """Return the solution of ``A x = b``, if A is well conditioned.

    Args:
        A: shape (n, n).
        b: shape (n,).
        least: what every pivot of rows of unit length must exceed [-].

    Returns:
        (x, regular): shape (n,), and whether the pivots are large enough; x only then.
    """
    n = len(A)
    U, x = np.empty((n, n + 1)), np.zeros(n)
    for i in range(n):
        length = math.sqrt(dot(A[i], A[i]))
        if not 0.0 < length < math.inf:
            return x, False
        for j in range(n):
            U[i, j] = A[i, j] / length
        U[i, n] = b[i] / length
    if not eliminate(U, least):
        return x, False
    for i in range(n - 1, -1, -1):
        s = U[i, n]
        for j in range(i + 1, n):
            s -= U[i, j] * x[j]
        x[i] = s / U[i, i]
    return x, True
