"""Quintic motions between two states of position, velocity and acceleration."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


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
    p0, v0, a0 = np.asarray(start, dtype=float)
    p1, v1, a1 = np.asarray(end, dtype=float)
    T = duration
    s = np.clip(np.asarray(t, dtype=float) / T, 0.0, 1.0)[..., None]
    # Coefficients in s = t / T; e* is what the cubic Taylor part leaves at the end.
    ep = p1 - p0 - v0 * T - 0.5 * a0 * T**2
    ev = (v1 - v0 - a0 * T) * T
    ea = (a1 - a0) * T**2
    c3 = 10.0 * ep - 4.0 * ev + 0.5 * ea
    c4 = -15.0 * ep + 7.0 * ev - ea
    c5 = 6.0 * ep - 3.0 * ev + 0.5 * ea
    p = p0 + v0 * T * s + 0.5 * a0 * T**2 * s**2 + s**3 * (c3 + s * (c4 + s * c5))
    v = v0 + a0 * T * s + s**2 * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5)) / T
    a = a0 + s * (6.0 * c3 + s * (12.0 * c4 + s * 20.0 * c5)) / T**2
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
