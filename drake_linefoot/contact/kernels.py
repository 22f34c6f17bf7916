"""Compiled parts of the momentum observer and of the wrench estimate."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.kernels import orthonormal_rows

Array = NDArray[np.float64]


@compiled
def coriolis_transpose(after: Array, before: Array, step: float, v: Array, Cv: Array) -> Array:
    """Return ``C'v = Mdot v - C v``, with Mdot a central difference.

    Args:
        after: mass matrix `step` later at constant velocity, shape (nv, nv).
        before: mass matrix `step` earlier, shape (nv, nv).
        step: [s].
        v: velocities, shape (nv,).
        Cv: Coriolis and centrifugal forces, shape (nv,).

    Returns:
        Shape (nv,).
    """
    out = -Cv
    for i in range(len(v)):
        change = 0.0
        for j in range(len(v)):
            change += (after[i, j] - before[i, j]) * v[j]
        out[i] += change / (2.0 * step)
    return out


@compiled
def least_squares_wrench(residual: Array, J: Array, tolerance: float) -> tuple[Array, bool]:
    """Return the wrenches f of least ``|J'f - residual|``.

    Args:
        residual: generalized force, shape (nv,).
        J: rows of both feet, shape (m, nv).
        tolerance: a row that others leave less of than this share depends on them.

    Returns:
        (f, independent): shape (m,), and whether the rows are independent; f only then.
    """
    Q, R, kept = orthonormal_rows(J, tolerance)
    m = len(J)
    f = np.zeros(m)
    if not kept.all():
        return f, False
    for i in range(m - 1, -1, -1):  # R'f = Q residual
        for k in range(len(residual)):
            f[i] += Q[i, k] * residual[k]
        for j in range(i + 1, m):
            f[i] -= R[j, i] * f[j]
        f[i] /= R[i, i]
    return f, True
