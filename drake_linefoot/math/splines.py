"""Quintic motions between two states of position, velocity and acceleration."""

import numpy as np

from drake_linefoot.math.compiled import compiled
from drake_linefoot.types import Array


@compiled
def quintic(start: Array, end: Array, duration: float, t: Array) -> Array:
    """Evaluate the quintic from `start` to `end`, both (position, velocity, acceleration).

    Args:
        start: position, velocity, acceleration at time 0, shape (3, d).
        end: the same at time `duration`, shape (3, d).
        duration: length of the motion [s], positive.
        t: times [s], shape (n,); clamped into [0, duration].

    Returns:
        Position, velocity and acceleration at the times, shape (3, n, d).

    Raises:
        ValueError: `duration` is not positive.
    """
    if not duration > 0.0:
        raise ValueError("duration of a motion: must be positive")
    T = duration
    n, d = len(t), start.shape[1]
    motion = np.empty((3, n, d))
    for j in range(d):
        # In s = t / T, with velocities and accelerations of the ends per T and per T^2.
        way = end[0, j] - start[0, j]
        v0, v1 = T * start[1, j], T * end[1, j]
        a0, a1 = T * T * start[2, j], T * T * end[2, j]
        c3 = 10.0 * way - 6.0 * v0 - 4.0 * v1 - 1.5 * a0 + 0.5 * a1
        c4 = -15.0 * way + 8.0 * v0 + 7.0 * v1 + 1.5 * a0 - a1
        c5 = 6.0 * way - 3.0 * v0 - 3.0 * v1 - 0.5 * a0 + 0.5 * a1
        for i in range(n):
            s = min(max(t[i] / T, 0.0), 1.0)
            p = start[0, j] + s * (v0 + s * (0.5 * a0 + s * (c3 + s * (c4 + s * c5))))
            v = v0 + s * (a0 + s * (3.0 * c3 + s * (4.0 * c4 + s * (5.0 * c5))))
            a = a0 + s * (6.0 * c3 + s * (12.0 * c4 + s * (20.0 * c5)))
            motion[0, i, j], motion[1, i, j], motion[2, i, j] = p, v / T, a / (T * T)
    return motion


@compiled
def bump(height: float, duration: float, t: Array) -> Array:
    """Evaluate a smooth bump, 64 h s^3 (1 - s)^3, at rest with no acceleration at both ends.

    Args:
        height: value at half time [m].
        duration: length [s], positive.
        t: times [s], shape (n,); clamped into [0, duration].

    Returns:
        Value, first and second derivative at the times, shape (3, n).

    Raises:
        ValueError: `duration` is not positive.
    """
    if not duration > 0.0:
        raise ValueError("duration of a bump: must be positive")
    c = 64.0 * height
    motion = np.empty((3, len(t)))
    for i in range(len(t)):
        s = min(max(t[i] / duration, 0.0), 1.0)
        u, du = s * (1.0 - s), 1.0 - 2.0 * s
        motion[0, i] = c * u * u * u
        motion[1, i] = 3.0 * c * u * u * du / duration
        motion[2, i] = 6.0 * c * u * (du * du - u) / (duration * duration)
    return motion


@compiled
def landing_bump(height: float, duration: float, t: Array) -> Array:
    """Evaluate ``h (s / s_h)^3 ((1 - s) / (1 - s_h))^2``: a bump that is not slow to land.

    It is highest at s_h = 0.6, begins at rest with no acceleration, and ends at rest.

    Args:
        height: h [m].
        duration: length [s], positive.
        t: times [s], shape (n,); clamped into [0, duration].

    Returns:
        Value, first and second derivative at the times, shape (3, n).

    Raises:
        ValueError: `duration` is not positive.
    """
    if not duration > 0.0:
        raise ValueError("duration of a bump: must be positive")
    c = height / (0.6**3 * 0.4**2)
    motion = np.empty((3, len(t)))
    for i in range(len(t)):
        s = min(max(t[i] / duration, 0.0), 1.0)
        motion[0, i] = c * s * s * s * (1.0 - s) * (1.0 - s)
        motion[1, i] = c * s * s * (3.0 + s * (5.0 * s - 8.0)) / duration
        motion[2, i] = c * s * (6.0 + s * (20.0 * s - 24.0)) / (duration * duration)
    return motion
