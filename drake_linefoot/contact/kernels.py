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
def update_residual(
    residual: Array,
    before: Array,
    now: Array,
    known: Array,
    actuation: Array,
    dt: float,
    gamma: float,
) -> Array:
    """Return tau_d of (21), the filtered generalized force of all contacts.

    Args:
        residual: the one of the last tick, shape (nv,).
        before: momentum of the last tick, shape (nv,).
        now: momentum of this tick, shape (nv,).
        known: part of its rate that is neither torque nor contact, (20), shape (nv,).
        actuation: generalized force of the actuators over the tick, shape (nv,).
        dt: length of the tick [s].
        gamma: filter constant, 0 <= gamma < 1.

    Returns:
        Shape (nv,).
    """
    out = np.empty(len(now))
    for i in range(len(now)):
        raw = (now[i] - before[i]) / dt - known[i] - actuation[i]
        out[i] = gamma * residual[i] + (1.0 - gamma) * raw
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
