"""Compiled: accelerations that joints may have near their stops."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.math.compiled import compiled

Array = NDArray[np.float64]


@compiled
def off_stops(
    q: Array, v: Array, a: Array, lower: Array, upper: Array, rate: float
) -> tuple[Array, bool]:
    """Return the accelerations nearest to wanted ones that keep joints off their stops.

    A joint comes no nearer to a stop than a critically damped spring at the stop lets it.

    Args:
        q: angles [rad], shape (n,).
        v: their rates [rad/s], shape (n,).
        a: wanted accelerations [rad/s^2], shape (n,).
        lower: stops [rad], shape (n,).
        upper: stops [rad], shape (n,).
        rate: of the spring, its natural frequency [1/s].

    Returns:
        (a, changed): shape (n,), and whether any differs from what is wanted.
    """
    allowed, changed = a.copy(), False
    for i in range(len(a)):
        low = rate * (rate * (lower[i] - q[i]) - 2.0 * v[i])
        high = rate * (rate * (upper[i] - q[i]) - 2.0 * v[i])
        allowed[i] = min(max(a[i], low), high)
        changed = changed or allowed[i] != a[i]
    return allowed, changed
