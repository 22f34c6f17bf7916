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
def orthonormal_rows(A: Array, tolerance: float) -> tuple[Array, Array, NDArray[np.bool_]]:
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
def motion_under_force(
    tau: float, start: Array, r_G: Array, force: Array, moment: Array, mass: float, g: Array
) -> Array:
    """Return the centroidal motion `tau` after `start`, under a constant force and moment.

    Args:
        tau: [s].
        start: CoM, its velocity and the angular momentum about r_G, shape (9,) or longer.
        r_G: the fixed point [m], shape (3,).
        force: of all contacts [N], shape (3,).
        moment: of all contacts about r_G [N m], shape (3,).
        mass: [kg].
        g: gravity [m/s^2], shape (3,).

    Returns:
        CoM, velocity, acceleration, angular momentum about the CoM and its rate, shape (5, 3).
    """
    out = np.empty((5, 3))
    weight = mass * g
    a = g + force / mass
    r0, v0 = start[:3] - r_G, start[3:6]
    r = r0 + tau * v0 + (0.5 * tau * tau) * a
    v = v0 + tau * a
    middle = r0 + (0.5 * tau) * v0 + (tau * tau / 6.0) * a  # the mean of r
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        L_G = start[6 + i] + tau * (moment[i] + middle[j] * weight[k] - middle[k] * weight[j])
        out[0, i], out[1, i], out[2, i] = r[i] + r_G[i], v[i], a[i]
        out[3, i] = L_G - mass * (r[j] * v[k] - r[k] * v[j])
        out[4, i] = moment[i] - (r[j] * force[k] - r[k] * force[j])
    return out


@compiled
def planned(
    plan: tuple[Array, Array, Array, Array, Array, Array, float], gravity: Array, t: float
) -> tuple[Array, Array]:
    """Return the motion and the wrenches of a centroidal plan at one time, held at its end.

    Args:
        plan: `CentroidalPlan.for_ticks`.
        gravity: [m/s^2], shape (3,).
        t: [s].

    Returns:
        (motion, wrench): shapes (5, 3) and (2, 5).
    """
    times, states, r_G, forces, moments, wrench, mass = plan
    k = 0
    while k + 1 < len(wrench) and times[k + 1] <= t + 1e-9:
        k += 1
    tau = min(t, times[-1]) - times[k]
    motion = motion_under_force(tau, states[k], r_G, forces[k], moments[k], mass, gravity)
    return motion, wrench[k]


@compiled
def from_quaternion(q: Array) -> Array:
    """Return the rotation of a quaternion in Drake's order w, x, y, z.

    Args:
        q: quaternion, shape (4,) or longer; need not be of unit length.

    Returns:
        Rotation matrix, shape (3, 3).

    Raises:
        ValueError: the quaternion is zero.
    """
    w, x, y, z = q[0], q[1], q[2], q[3]
    n = w * w + x * x + y * y + z * z
    if n == 0.0:
        raise ValueError("quaternion is zero")
    s = 2.0 / n
    R = np.empty((3, 3))
    R[0, 0], R[0, 1], R[0, 2] = 1.0 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)
    R[1, 0], R[1, 1], R[1, 2] = s * (x * y + w * z), 1.0 - s * (x * x + z * z), s * (y * z - w * x)
    R[2, 0], R[2, 1], R[2, 2] = s * (x * z - w * y), s * (y * z + w * x), 1.0 - s * (x * x + y * y)
    return R
