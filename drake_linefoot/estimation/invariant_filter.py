"""The right-invariant extended Kalman filter with contacts, as functions of arrays.

Hartley, Ghaffari, Eustice and Grizzle, "Contact-aided invariant extended Kalman filtering for
robot state estimation", IJRR 39(4), 2020; docs/mathematics.md has its equations. The state X has
orientation, velocity and position of the base B (where the IMU is) and four contact points, heel
and toe of both feet; beside it stand the biases of gyroscope and accelerometer. The error is
``X_hat X^-1 = Exp(xi)`` in W, ``zeta = b_hat - b``, in the order of `filter_state`.
"""

import math

import numpy as np

from drake_linefoot.constants import GRAVITY
from drake_linefoot.estimation.filter_state import (
    ACCELEROMETER_BIAS,
    CONTACT,
    ERRORS,
    GYRO_BIAS,
    PLACE,
    POINTS,
    TURN,
    VELOCITY,
    Filter,
    Noise,
)
from drake_linefoot.math.compiled import compiled, inlined
from drake_linefoot.math.linear import cholesky, dot, forward
from drake_linefoot.math.rotation import SMALL_ANGLE, cross, skew
from drake_linefoot.types import Array

UNKNOWN = 0.2  # [-] of how far a point sinks in while its load changes


@compiled
def exponential(phi: Array) -> tuple[Array, Array]:
    """Return the rotation of a rotation vector [rad] and its left Jacobian, shapes (3, 3)."""
    angle2 = dot(phi, phi)
    angle = math.sqrt(angle2)
    if angle < SMALL_ANGLE:
        a, b, c = 1.0 - angle2 / 6.0, 0.5 - angle2 / 24.0, 1.0 / 6.0 - angle2 / 120.0
    else:
        sine, versine = math.sin(angle), 1.0 - math.cos(angle)
        a, b, c = sine / angle, versine / angle2, (angle - sine) / (angle * angle2)
    S, eye = skew(phi), np.eye(3)
    S2 = S @ S
    return eye + a * S + b * S2, eye + b * S + c * S2


@inlined
def retract(s: Filter, xi: Array) -> None:
    """Replace the state by ``Exp(xi) X``, and the biases by their sums with `xi`.

    Args:
        s: of a filter; written.
        xi: error, shape (ERRORS,).
    """
    turn, J = exponential(xi[TURN:VELOCITY])
    s.R[:] = turn @ s.R[:]
    s.v[:] = turn @ s.v[:] + J @ xi[VELOCITY:PLACE]
    s.p[:] = turn @ s.p[:] + J @ xi[PLACE:CONTACT]
    for k in range(POINTS):
        at = CONTACT + 3 * k
        s.d[k] = turn @ s.d[k] + J @ xi[at : at + 3]
    s.gyro_bias[:] += xi[GYRO_BIAS:ACCELEROMETER_BIAS]
    s.accelerometer_bias[:] += xi[ACCELEROMETER_BIAS:]


@inlined
def responses(s: Filter, imu: Array, h: float) -> tuple[Array, Array, Array]:
    """Return how errors of a tick's sample act on the error after it.

    Args:
        s: of a filter, before the tick.
        imu: angular velocity and specific force, shape (6,).
        h: length of the tick [s].

    Returns:
        The rotation R after it, and the responses to gyroscope and accelerometer that read too
        much, shapes (3, 3), (ERRORS, 3) and (ERRORS, 3).
    """
    w = imu[:3] - s.gyro_bias[:]
    half = exponential(0.5 * h * w)[0]
    R_mid = s.R[:] @ half
    R = R_mid @ half
    turned, pushed = np.zeros((ERRORS, 3)), np.zeros((ERRORS, 3))
    turned[TURN:VELOCITY] = h * R_mid
    # Of a turn that comes from the left, X stays behind: the adjoint, with gravity's part.
    v = s.v[:] + h * GRAVITY
    p = s.p[:] + h * v
    turned[VELOCITY:PLACE] = skew(v) @ turned[:3]
    turned[PLACE:CONTACT] = skew(p) @ turned[:3]
    for k in range(POINTS):
        at = CONTACT + 3 * k
        turned[at : at + 3] = skew(s.d[k]) @ turned[:3]
    pushed[VELOCITY:PLACE] = h * R
    pushed[PLACE:CONTACT] = h * h * R
    return R, turned, pushed


@compiled
def transition(X: Array, h: float, turned: Array, pushed: Array) -> Array:
    """Return Phi X, the error of a tick ago carried on, shape (ERRORS, n).

    Exact in xi: the motion is group-affine; of first order in the errors of the biases.

    Args:
        X: shape (ERRORS, n).
        h: length of the tick [s].
        turned: response to the gyroscope, see `responses`.
        pushed: response to the accelerometer.
    """
    Y = X - turned @ X[GYRO_BIAS:ACCELEROMETER_BIAS] - pushed @ X[ACCELEROMETER_BIAS:]
    fall = h * (skew(GRAVITY) @ X[TURN:VELOCITY])
    Y[VELOCITY:PLACE] += fall
    Y[PLACE:CONTACT] += h * (X[VELOCITY:PLACE] + fall)
    return Y


@inlined
def rates_of(s: Filter, load: Array, h: float, c: Noise) -> Array:
    """Return how fast the loads of the points change [N/s], shape (POINTS,).

    Args:
        s: of a filter; its mean loads are written.
        load: normal force of each point [N], shape (POINTS,).
        h: length of the tick [s].
        c: noise.
    """
    rates = (load - s.load[:]) / c.change
    s.load[:] += h * rates
    return rates


@compiled
def sunk(load: float, rate: float, c: Noise) -> float:
    """Return how deep a point has sunk in [m]: load over stiffness, less while it is pressed in.

    Args:
        load: that is estimated, which is late [N].
        rate: at which it changes [N/s].
        c: noise.
    """
    speed = rate / c.stiffness
    return (load / c.stiffness + c.delay * speed) * (1.0 - c.dissipation * speed)


@inlined
def propagate(s: Filter, imu: Array, loads: tuple[Array, Array], h: float, c: Noise) -> None:
    """Carry state and covariance over a tick.

    The order of the steps is that of Drake's plant: what the IMU says holds at the end of the
    tick, and velocity goes before position.

    Args:
        s: of a filter; written.
        imu: angular velocity [rad/s] and specific force [m/s^2] in B, shape (6,).
        loads: normal force of each point [N] and how fast it changes [N/s], shapes (POINTS,).
        h: length of the tick [s].
        c: noise.
    """
    R, turned, pushed = responses(s, imu, h)
    P = transition(s.P[:], h, turned, pushed)
    P = transition(P.T.copy(), h, turned, pushed)
    P += (c.gyro**2 / h) * (turned @ turned.T) + (c.accelerometer**2 / h) * (pushed @ pushed.T)
    for i in range(3):
        P[GYRO_BIAS + i, GYRO_BIAS + i] += h * c.gyro_walk**2
        P[ACCELEROMETER_BIAS + i, ACCELEROMETER_BIAS + i] += h * c.accelerometer_walk**2
    for k in range(POINTS):
        load, rate = loads[0][k], loads[1][k]
        borne = load + c.change * min(rate, 0.0)  # soon
        slip = c.slip * (1.0 + c.full / max(borne, 1e-3 * c.full))
        unknown = UNKNOWN * c.change * rate / c.stiffness
        at = CONTACT + 3 * k
        for i in range(at, at + 3):
            P[i, i] += s.active[k] * h * slip**2
        P[at + 2, at + 2] += s.active[k] * h / c.change * unknown**2
    s.P[:] = P
    s.w[:] = R @ (imu[:3] - s.gyro_bias[:])
    s.R[:] = R
    s.v[:] += h * (R @ (imu[3:] - s.accelerometer_bias[:]) + GRAVITY)
    s.p[:] += h * s.v[:]
    s.time += h


@compiled
def anchor(s: Filter, k: int, p_BC: Array, N: Array) -> None:
    """Let a point hold where it is now.

    Args:
        s: of a filter; written.
        k: the point.
        p_BC: where kinematics say it is [m], shape (3,).
        N: covariance of that in W, shape (3, 3).
    """
    at = CONTACT + 3 * k
    s.d[k] = s.p[:] + s.R[:] @ p_BC
    s.P[at : at + 3] = s.P[PLACE:CONTACT]
    s.P[:, at : at + 3] = s.P[:, PLACE:CONTACT]
    s.P[at : at + 3, at : at + 3] += N
    s.missed[k] = 0.0


@inlined
def correct(s: Filter, k: int, p_BC: Array, N: Array, gate: float) -> bool:
    """Take in where kinematics say that a point is; return whether it was believed.

    Args:
        s: of a filter; written.
        k: the point.
        p_BC: position of the point in B [m], shape (3,).
        N: covariance of that in W, shape (3, 3).
        gate: largest squared Mahalanobis distance of what is believed.
    """
    at, P = CONTACT + 3 * k, s.P[:]
    z = s.R[:] @ p_BC - (s.d[k] - s.p[:])
    C = np.ascontiguousarray(P[PLACE:CONTACT] - P[at : at + 3])  # H P
    S = C[:, PLACE:CONTACT] - C[:, at : at + 3] + N
    L, positive = cholesky(S)
    y = z.copy().reshape(3, 1)
    forward(L, y)
    s.innovation[k] = z
    s.nis[k] = y[0, 0] ** 2 + y[1, 0] ** 2 + y[2, 0] ** 2
    if not (positive and s.nis[k] <= gate):
        return False
    forward(L, C)
    P -= C.T.copy() @ C
    retract(s, -(C.T.copy() @ y)[:, 0])
    return True


@inlined
def tick(
    s: Filter, imu: Array, points: tuple[Array, Array], load: Array, h: float, c: Noise
) -> None:
    """Carry a filter over a tick and take in what holds.

    Args:
        s: of a filter; written.
        imu: angular velocity and specific force in B, shape (6,).
        points: see `contact_points`: positions and their Jacobians by joint angles.
        load: estimated normal force of each point [N], 0 in the air, shape (POINTS,).
        h: length of the tick [s].
        c: noise.
    """
    rates = rates_of(s, load, h, c)
    propagate(s, imu, (load, rates), h, c)
    s.alone += h
    for k in range(POINTS):
        s.nis[k] = np.nan
        s.innovation[k] = np.nan
        held = s.active[k] > 0.5
        s.active[k] = 1.0 if load[k] > (c.release if held else c.touch) else 0.0
        if s.active[k] < 0.5:
            continue
        # The ground under the point gives way; where it was touched is what stays.
        place = points[0][k] + s.R[2] * sunk(load[k], rates[k], c)
        J = s.R[:] @ points[1][k]
        N = c.encoder**2 * (J @ J.T.copy()) + c.point**2 * np.eye(3)
        s.since[k] = s.since[k] + h if held else 0.0
        if s.since[k] <= c.settle:  # the impact is not over
            anchor(s, k, place, N)
        elif correct(s, k, place, N, c.gate):
            s.missed[k] = 0.0
            s.alone = 0.0
        else:
            s.refused += 1.0
            s.missed[k] += h
            if s.missed[k] > c.patience:
                s.slips += 1.0
                anchor(s, k, place, N)


def begin(s: Filter, imu: Array, points: Array, deviations: Array) -> None:
    """Begin at rest: upright is where the specific force points, heading and place are 0.

    Args:
        s: of a filter; written.
        imu: angular velocity and specific force in B, shape (6,).
        points: heels and toes in B [m], shape (POINTS, 3); the lowest one is at height 0.
        deviations: standard deviations of the error at the beginning, shape (ERRORS,); those of
            the points are those of the place.
    """
    f = imu[3:] / math.sqrt(dot(imu[3:], imu[3:]))
    up = np.array([0.0, 0.0, 1.0])
    axis = cross(f, up)
    sine = math.sqrt(dot(axis, axis))
    angle = math.atan2(sine, f[2])
    R = exponential(axis * (angle / sine if sine > 0.0 else 1.0))[0]
    yaw = math.atan2(R[1, 0], R[0, 0])
    s.R[:] = exponential(-yaw * up)[0] @ R
    s.v[:] = 0.0
    s.p[:] = 0.0
    s.p[2] = -np.min(points @ s.R[2])
    s.P[:] = np.diag(deviations**2)
    s.active[:] = 0.0
    s.time = 0.0
    for k in range(POINTS):
        anchor(s, k, points[k], np.zeros((3, 3)))
