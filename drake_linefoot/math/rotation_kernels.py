"""Compiled rotations."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.math.compiled import compiled

Array = NDArray[np.float64]

SMALL_ANGLE = 1e-4  # [rad]; below it the series is exact to rounding


@compiled
def log_rows(R: Array) -> Array:
    """Return the rotation vectors of rotation matrices.

    Args:
        R: shape (n, 3, 3).

    Returns:
        [rad], shape (n, 3), of norm at most pi.
    """
    out = np.empty((len(R), 3))
    for i in range(len(R)):
        log_into(R[i], out[i])
    return out


@compiled
def log_into(R: Array, theta: Array) -> None:
    """Write the rotation vector of R, shape (3, 3), into `theta`, shape (3,)."""
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
    else:
        log_near_half_turn(R, angle, theta)


@compiled
def log_near_half_turn(R: Array, angle: float, theta: Array) -> None:
    """Turn sin(angle) axis in `theta` into the rotation vector, for an angle close to pi.

    (R + R') / 2 - cos I = (1 - cos) a a', whose longest column is along the axis a.
    """
    outer = 0.5 * (R + R.T) - math.cos(angle) * np.eye(3)
    column = 0
    for k in range(1, 3):
        if outer[k, k] > outer[column, column]:
            column = k
    axis = outer[:, column]
    length = math.sqrt(axis[0] ** 2 + axis[1] ** 2 + axis[2] ** 2)
    along = axis[0] * theta[0] + axis[1] * theta[1] + axis[2] * theta[2]
    sign = -1.0 if along < 0.0 else 1.0
    theta[:] = sign * angle / length * axis
