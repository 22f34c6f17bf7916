"""Compiled parts of the momentum observer and of the wrench estimate."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.kernels import dot, orthonormal_rows

Array = NDArray[np.float64]


@compiled
def moved_positions(q: Array, v: Array, step: float) -> Array:
    """Return positions a short time later, at constant velocity.

    Args:
        q: positions of a floating base, quaternion first, with a joint for each further
            velocity, shape (nv + 1,).
        v: velocities, angular velocity of the base first, shape (nv,).
        step: the time [s].

    Returns:
        Shape (nv + 1,); the quaternion is not of unit length.
    """
    rate = np.empty(len(q))
    w, x, y, z = 0.5 * q[0], 0.5 * q[1], 0.5 * q[2], 0.5 * q[3]
    rate[0] = -x * v[0] - y * v[1] - z * v[2]
    rate[1] = w * v[0] + z * v[1] - y * v[2]
    rate[2] = -z * v[0] + w * v[1] + x * v[2]
    rate[3] = y * v[0] - x * v[1] + w * v[2]
    rate[4:] = v[3:]
    for i in range(len(q)):
        rate[i] = q[i] + step * rate[i]
    return rate


@compiled
def coriolis_transpose(after: Array, now: Array, step: float, v: Array, Cv: Array) -> Array:
    """Return ``C'v = Mdot v - C v``, with Mdot a difference.

    Args:
        after: mass matrix `step` later at constant velocity, shape (nv, nv).
        now: mass matrix, shape (nv, nv).
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
            change += (after[i, j] - now[i, j]) * v[j]
        out[i] += change / step
    return out


@compiled
def momentum_and_rate(
    after: Array, now: Array, step: float, v: Array, Cv: Array, tau_g: Array
) -> tuple[Array, Array]:
    """Return ``p = M v`` and ``C'v + tau_g``; arguments as in `coriolis_transpose`.

    Args:
        after: shape (nv, nv).
        now: shape (nv, nv).
        step: [s].
        v: shape (nv,).
        Cv: shape (nv,).
        tau_g: generalized gravity, shape (nv,).

    Returns:
        (p, known): shapes (nv,).
    """
    momentum = np.empty(len(v))
    for i in range(len(v)):
        momentum[i] = dot(now[i], v)
    return momentum, coriolis_transpose(after, now, step, v, Cv) + tau_g


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


@compiled
def flag(force: float, stood: bool, touch: float, release: float) -> bool:
    """Return whether a foot stands, with hysteresis; see `contact_flags`."""
    return force > (release if stood else touch)


@compiled
def next_estimate(
    before: Array,
    momentum: Array,
    known: Array,
    torque: Array,
    actuated: NDArray[np.int64],
    dt: float,
    gamma: float,
    J: Array,
    tolerance: float,
    touch: float,
    release: float,
) -> tuple[Array, bool]:
    """Return the state of the estimator a tick later: momentum, residual, wrenches, flags.

    Args:
        before: the state, shape (2 nv + 12,).
        momentum: of this tick, shape (nv,).
        known: part of its rate that is neither torque nor contact, shape (nv,).
        torque: of the actuators over the tick [N m], shape (na,).
        actuated: index of each actuator in v, shape (na,).
        dt: length of the tick [s].
        gamma: filter constant, 0 <= gamma < 1.
        J: rows of both feet, shape (2, 5, nv).
        tolerance: see `least_squares_wrench`.
        touch: force above which a foot in the air counts as standing [N].
        release: force below which a standing foot counts as in the air [N].

    Returns:
        (state, independent): shape (2 nv + 12,), and whether the wrenches could be told apart;
        wrenches and flags are to be set where they could not.
    """
    nv = len(momentum)
    actuation = np.zeros(nv)
    for k in range(len(actuated)):
        actuation[actuated[k]] = torque[k]
    state = np.empty(2 * nv + 12)
    state[:nv] = momentum
    residual = update_residual(
        before[nv : 2 * nv], before[:nv], momentum, known, actuation, dt, gamma
    )
    wrench, independent = least_squares_wrench(residual, J.reshape(10, nv), tolerance)
    state[nv : 2 * nv], state[2 * nv : 2 * nv + 10] = residual, wrench
    for side in range(2):
        at = 2 * nv + 10 + side
        state[at] = 1.0 if flag(wrench[5 * side + 2], before[at] > 0.5, touch, release) else 0.0
    return state, independent
