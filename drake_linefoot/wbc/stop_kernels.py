"""Compiled: accelerations that joints may have near their stops."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.math.compiled import compiled

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@compiled
def off_stops(
    q: Array,
    v: Array,
    vdot: Array,
    index_q: Indices,
    index_v: Indices,
    lower: Array,
    upper: Array,
    rate: float,
) -> tuple[Array, bool]:
    """Return the accelerations nearest to wanted ones that keep joints off their stops.

    A joint comes no nearer to a stop than a critically damped spring at the stop lets it.

    Args:
        q: positions of the robot, shape (nq,).
        v: its velocities, shape (nv,).
        vdot: its wanted accelerations, shape (nv,).
        index_q: of the n joints in q, shape (n,).
        index_v: of the n joints in v, shape (n,).
        lower: stops [rad], shape (n,).
        upper: stops [rad], shape (n,).
        rate: of the spring, its natural frequency [1/s].

    Returns:
        (allowed, changed): accelerations of the joints [rad/s^2], shape (n,), and whether any
        differs from what is wanted.
    """
    allowed, changed = np.empty(len(index_v)), False
    for i in range(len(index_v)):
        angle, speed, a = q[index_q[i]], v[index_v[i]], vdot[index_v[i]]
        low = rate * (rate * (lower[i] - angle) - 2.0 * speed)
        high = rate * (rate * (upper[i] - angle) - 2.0 * speed)
        allowed[i] = min(max(a, low), high)
        changed = changed or allowed[i] != a
    return allowed, changed
