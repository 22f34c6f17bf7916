"""Quintic motions between two states of position, velocity and acceleration."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

# Powers of s from position, velocity and acceleration at s = 0 and at s = 1.
_COEFFICIENTS = np.array(
    [
        [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.5, 0.0, 0.0, 0.0],
        [-10.0, -6.0, -1.5, 10.0, -4.0, 0.5],
        [15.0, 8.0, 1.5, -15.0, 7.0, -1.0],
        [-6.0, -3.0, -0.5, 6.0, -3.0, 0.5],
    ]
)
_FIRST = np.arange(1.0, 6.0)[:, None]  # factors of the first derivative
_SECOND = (np.arange(2.0, 6.0) * np.arange(1.0, 5.0))[:, None]  # and of the second


def quintic(
    start: ArrayLike, end: ArrayLike, duration: float, t: ArrayLike
) -> tuple[Array, Array, Array]:
    """Evaluate the quintic from `start` to `end`, both (position, velocity, acceleration).

    Args:
        start: position, velocity, acceleration at time 0, shape (3, d).
        end: the same at time `duration`, shape (3, d).
        duration: length of the motion [s], positive.
        t: times [s], shape (n,) or scalar; clamped into [0, duration].

    Returns:
        (position, velocity, acceleration), each of shape (n, d), or (d,) for scalar t.

    Raises:
        ValueError: `duration` is not positive.
    """
    if not duration > 0.0:
        raise ValueError(f"duration = {duration}: must be positive")
    T = duration
    # In s = t / T, with velocities and accelerations of the ends per T and per T^2.
    unit = np.array([[1.0], [T], [T * T]])
    ends = np.concatenate([np.asarray(start) * unit, np.asarray(end) * unit])
    c = _COEFFICIENTS @ ends
    s = np.minimum(np.maximum(np.asarray(t, dtype=float) / T, 0.0), 1.0)
    powers = np.ones((*s.shape, 6))
    for k in range(1, 6):
        powers[..., k] = powers[..., k - 1] * s
    p = powers @ c
    v = powers[..., :5] @ (_FIRST * c[1:]) / T
    a = powers[..., :4] @ (_SECOND * c[2:]) / (T * T)
    return p, v, a


def bump(height: float, duration: float, t: ArrayLike) -> tuple[Array, Array, Array]:
    """Evaluate a smooth bump, 64 h s^3 (1 - s)^3, at rest with no acceleration at both ends.

    Args:
        height: value at half time [m].
        duration: length [s], positive.
        t: times [s], any shape; clamped into [0, duration].

    Returns:
        (value, first derivative, second derivative), each shaped like `t`.

    Raises:
        ValueError: `duration` is not positive.
    """
    if not duration > 0.0:
        raise ValueError(f"duration = {duration}: must be positive")
    s = np.clip(np.asarray(t, dtype=float) / duration, 0.0, 1.0)
    u = s * (1.0 - s)
    du = 1.0 - 2.0 * s
    c = 64.0 * height
    value = c * u**3
    rate = 3.0 * c * u**2 * du / duration
    curvature = 6.0 * c * u * (du**2 - u) / duration**2
    return value, rate, curvature
