"""Compiled parts of the MPC's reference: the CoM that follows a DCM, legs that follow a plan."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.gait.swing_kernels import line_turn
from drake_linefoot.math.compiled import compiled

Array = NDArray[np.float64]


@compiled
def responses(rate: float, omega: float, tau: float) -> tuple[float, float]:
    """Return how the CoM follows after `tau` [s]: from its own start, and from the DCM's.

    The second is ``w (exp(rate t) - exp(-w t)) / (rate + w)``, here without the difference
    of two near numbers, so that a DCM that decays just as fast as the CoM is no exception.
    """
    decay = math.exp(-omega * tau)
    x = (rate + omega) * tau
    growth = 1.0 if abs(x) < 1e-12 else math.expm1(x) / x
    return decay, omega * tau * decay * growth


@compiled
def follow_dcm(com: Array, pieces: Array, times: Array, omega: float) -> tuple[Array, Array]:
    """Return the CoM that follows a DCM trajectory; see `pendulum.follow_dcm`.

    Args:
        com: CoM at the start of the first piece [m], shape (2,).
        pieces: rows of start, end, centre (2), amplitude (2) and rate, shape (p, 7).
        times: increasing [s], shape (n,).
        omega: natural frequency [1/s].

    Returns:
        (position, velocity) of the CoM, shape (n, 2) each.
    """
    position, velocity = np.empty((len(times), 2)), np.empty((len(times), 2))
    now = com.copy()  # where the CoM is when the piece starts
    p, last = 0, len(pieces) - 1
    for i in range(len(times)):
        while p < last and times[i] >= pieces[p, 1]:
            free, forced = responses(pieces[p, 6], omega, pieces[p, 1] - pieces[p, 0])
            for j in range(2):
                centre, amplitude = pieces[p, 2 + j], pieces[p, 4 + j]
                now[j] = centre + free * (now[j] - centre) + forced * amplitude
            p += 1
        tau = times[i] - pieces[p, 0]
        free, forced = responses(pieces[p, 6], omega, tau)
        growth = math.exp(pieces[p, 6] * tau)
        for j in range(2):
            centre, amplitude = pieces[p, 2 + j], pieces[p, 4 + j]
            position[i, j] = centre + free * (now[j] - centre) + forced * amplitude
            velocity[i, j] = omega * (centre + amplitude * growth - position[i, j])
    return position, velocity


@compiled
def into_torso(R: Array, a: Array, out: Array) -> None:
    """Write ``R' a``, shapes (3, 3) and (3,)."""
    for i in range(3):
        out[i] = R[0, i] * a[0] + R[1, i] * a[1] + R[2, i] * a[2]


@compiled
def lines_in_torso(
    r: Array, v: Array, R: Array, Omega: Array, offset: Array, position: Array, velocity: Array
) -> Array:
    """Return planned contact lines as the legs see them.

    Args:
        r: CoM [m], shape (K, 3).
        v: its velocity [m/s], shape (K, 3).
        R: torso orientation, shape (K, 3, 3).
        Omega: torso angular velocity in B [rad/s], shape (K, 3).
        offset: of the CoM in B [m], as if fixed there, shape (3,).
        position: [x, y, z, pitch, yaw] of both lines, shape (2, K, 5).
        velocity: its rate, shape (2, K, 5).

    Returns:
        Middles [m], directions, velocities relative to the torso [m/s] and angular velocities
        relative to it [rad/s], all in B, shape (4, 2, K, 3).
    """
    K = len(r)
    out, motion = np.empty((4, 2, K, 3)), np.zeros((3, K, 5))
    p, d = np.empty(3), np.empty(3)
    for side in range(2):
        motion[0], motion[1] = position[side], velocity[side]
        turn = line_turn(motion)
        for k in range(K):
            into_torso(R[k], position[side, k, :3] - r[k], p)
            p += offset  # from the torso's origin
            out[0, side, k] = p
            into_torso(R[k], turn[0, k], out[1, side, k])
            # The torso turns about the CoM, which moves by v.
            into_torso(R[k], velocity[side, k, :3] - v[k], d)
            p -= offset
            w = Omega[k]
            out[2, side, k, 0] = d[0] - (w[1] * p[2] - w[2] * p[1])
            out[2, side, k, 1] = d[1] - (w[2] * p[0] - w[0] * p[2])
            out[2, side, k, 2] = d[2] - (w[0] * p[1] - w[1] * p[0])
            into_torso(R[k], turn[1, k], out[3, side, k])
            out[3, side, k] -= w
    return out


@compiled
def headings(yaw: float, turn_rate: float, after: Array) -> Array:
    """Return the orientation of a torso that only turns.

    Args:
        yaw: now [rad].
        turn_rate: [rad/s].
        after: times from now [s], shape (n,).

    Returns:
        Rotation matrices, shape (n, 3, 3).
    """
    R = np.zeros((len(after), 3, 3))
    for i in range(len(after)):
        c, s = math.cos(yaw + turn_rate * after[i]), math.sin(yaw + turn_rate * after[i])
        R[i, 0, 0], R[i, 0, 1], R[i, 1, 0], R[i, 1, 1], R[i, 2, 2] = c, -s, s, c, 1.0
    return R


@compiled
def contact_frames(position: Array) -> Array:
    """Return the frames of contact lines, ``rot_z(yaw) rot_y(pitch)``.

    Args:
        position: [x, y, z, pitch, yaw] of both lines, shape (2, K, 5).

    Returns:
        Shape (K, 2, 3, 3).
    """
    K = position.shape[1]
    R = np.zeros((K, 2, 3, 3))
    for side in range(2):
        for k in range(K):
            pitch, yaw = position[side, k, 3], position[side, k, 4]
            c, s, u, w = math.cos(yaw), math.sin(yaw), math.cos(pitch), math.sin(pitch)
            R[k, side, 0, 0], R[k, side, 0, 1], R[k, side, 0, 2] = c * u, -s, c * w
            R[k, side, 1, 0], R[k, side, 1, 1], R[k, side, 1, 2] = s * u, c, s * w
            R[k, side, 2, 0], R[k, side, 2, 2] = -w, u
    return R
