"""Rotations: what a tick or an update computes; elsewhere scipy.spatial.transform does."""

import math

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from drake_linefoot.math.compiled import compiled, inlined
from drake_linefoot.types import Array

SMALL_ANGLE = 1e-4  # [rad]; below it the series is exact to rounding


@compiled
def cross(a: Array, b: Array) -> Array:
    """Return the cross product of two vectors, shape (3,)."""
    # Not numpy.cross, which compiles for three times as long.
    c = np.empty(3)
    c[0] = a[1] * b[2] - a[2] * b[1]
    c[1] = a[2] * b[0] - a[0] * b[2]
    c[2] = a[0] * b[1] - a[1] * b[0]
    return c


@compiled
def skew(a: Array) -> Array:
    """Return the matrix of the cross product, ``skew(a) @ b == cross(a, b)``.

    Args:
        a: shape (3,).

    Returns:
        Shape (3, 3).
    """
    S = np.zeros((3, 3))
    S[2, 1], S[0, 2], S[1, 0] = a[0], a[1], a[2]
    S[1, 2], S[2, 0], S[0, 1] = -a[0], -a[1], -a[2]
    return S


@compiled
def axes_on_plane(x: Array, slope: Array) -> Array:
    """Return the axes of a frame whose y lies in a plane: those of a sole on sloping ground.

    Args:
        x: its x axis, a unit vector, shape (3,).
        slope: rise of the plane per metre along x and y of the world, shape (2,).

    Returns:
        Shape (3, 3).
    """
    normal, R = np.array((-slope[0], -slope[1], 1.0)), np.empty((3, 3))
    y = cross(normal, x)
    R[:, 0] = x
    R[:, 1] = y / math.sqrt(y[0] ** 2 + y[1] ** 2 + y[2] ** 2)
    R[:, 2] = cross(x, R[:, 1])
    return R


@inlined
def log(R: Array) -> Array:
    """Return the rotation vector of a rotation.

    Args:
        R: rotation matrix, shape (3, 3).

    Returns:
        [rad], of norm at most pi, shape (3,).
    """
    theta = np.empty(3)
    theta[0] = 0.5 * (R[2, 1] - R[1, 2])
    theta[1] = 0.5 * (R[0, 2] - R[2, 0])
    theta[2] = 0.5 * (R[1, 0] - R[0, 1])
    sine = math.sqrt(theta[0] ** 2 + theta[1] ** 2 + theta[2] ** 2)
    cosine = 0.5 * (R[0, 0] + R[1, 1] + R[2, 2] - 1.0)
    angle = math.atan2(sine, cosine)
    if sine >= SMALL_ANGLE:
        theta *= angle / sine
    elif cosine >= 0.0:
        theta *= 1.0 + sine * sine / 6.0  # angle / sin(angle)
    else:  # near half a turn: (R + R') / 2 - cos I = (1 - cos) a a', the longest column is along a
        column = 0
        for k in range(1, 3):
            if R[k, k] > R[column, column]:
                column = k
        axis = 0.5 * (R[:, column] + R[column])
        axis[column] -= math.cos(angle)
        length = math.sqrt(axis[0] ** 2 + axis[1] ** 2 + axis[2] ** 2)
        along = axis[0] * theta[0] + axis[1] * theta[1] + axis[2] * theta[2]
        sign = -1.0 if along < 0.0 else 1.0
        theta[:] = sign * angle / length * axis
    return theta


@compiled
def rotation_error(R: Array, R_d: Array) -> Array:
    """Return eta, the body-frame rotation vector from `R_d` to `R`, (7).

    Args:
        R: actual rotation, shape (3, 3).
        R_d: desired rotation, shape (3, 3).

    Returns:
        eta = log(R_d.T R) [rad], shape (3,).
    """
    return log(R_d.T @ R)


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


def roll_pitch_yaw(quaternion: Array) -> Array:
    """Return roll, pitch, yaw of rotations, ``R = R_z(yaw) R_y(pitch) R_x(roll)``.

    Args:
        quaternion: in Drake's order w, x, y, z, shape (..., 4); need not be of unit length.

    Returns:
        Angles [rad], shape (..., 3).
    """
    rows = np.asarray(quaternion, dtype=float)
    rotations = Rotation.from_quat(rows, scalar_first=True)
    # Looking straight up or down it chooses one of the many pairs of roll and yaw, and warns.
    return np.asarray(rotations.as_euler("ZYX", suppress_warnings=True)[..., ::-1])


def wrap_angle(angle: ArrayLike) -> Array:
    """Return `angle` [rad] shifted by whole turns into [-pi, pi)."""
    wrapped = (np.asarray(angle, dtype=float) + np.pi) % (2.0 * np.pi) - np.pi
    # Just below -pi the remainder rounds up to a whole turn.
    return np.where(wrapped < np.pi, wrapped, -np.pi)


_NEXT, _LAST = np.array([1, 2, 0]), np.array([2, 0, 1])


def crosses(a: Array, b: Array) -> Array:
    """Return a x b of many vectors, shapes (..., 3): np.cross takes thrice the time for a few."""
    return a[..., _NEXT] * b[..., _LAST] - a[..., _LAST] * b[..., _NEXT]
