"""Strictly prioritised accelerations: orthonormal rows in the metric of the mass matrix.

A task asks for ``J vdot = b``. Tasks are ordered; each is met as well as the ones above
leave room for, in the dynamically consistent sense of [5], [30]: with M = L L' and
z = L' vdot, the recursion of null-space projections equals a forward substitution on the
rows of the stacked ``J L^-T``, made orthonormal from the highest priority down.

As many independent rows as there are velocities leave nothing to the metric or the order: then they
are solved as they stand, in a third of the time.
"""

import numpy as np

from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.linear import (
    backward,
    cholesky,
    forward,
    orthonormal_rows,
    solve_square,
)
from drake_linefoot.types import Array

RANK_TOLERANCE = 1e-5  # [-] of a row's norm in the metric of M^-1
LEAST_PIVOT = 1e-3  # [-] of rows of unit length; below it rows may be dependent


@compiled
def prioritised_acceleration(M: Array, J: Array, b: Array) -> tuple[Array, int, bool]:
    """Return the acceleration that meets the rows ``J vdot = b`` one after the other.

    Where rows leave freedom, the acceleration is the one of least ``vdot' M vdot``. A row
    that depends on the rows above it is dropped.

    Args:
        M: mass matrix, shape (nv, nv).
        J: rows, highest priority first, shape (m, nv).
        b: shape (m,).

    Returns:
        (vdot, dropped, positive): shape (nv,), the number of dropped rows, and whether the
        mass matrix is positive definite.
    """
    n, m = len(M), len(b)
    L, positive = cholesky(M)
    if not positive:
        return np.zeros(n), 0, False
    if m == n:
        vdot, regular = solve_square(J, b, LEAST_PIVOT)
        if regular:
            return vdot, 0, True
    J_hat = J.T.copy()
    forward(L, J_hat)  # L^-1 J'
    Q, R, kept = orthonormal_rows(J_hat.T.copy(), RANK_TOLERANCE)
    z, y, dropped = np.zeros((n, 1)), np.zeros(m), m
    for i in range(m):
        if kept[i]:
            s = b[i]
            for j in range(i):
                s -= R[i, j] * y[j]
            y[i] = s / R[i, i]
            z[:, 0] += y[i] * Q[i]
            dropped -= 1
    backward(L, z)  # vdot = L'^-1 z
    return z[:, 0].copy(), dropped, True
