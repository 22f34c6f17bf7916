"""Compiled: what a recorder computes of many samples."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.kernels import motion_under_force

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]


@compiled
def add_contacts(
    sample: Numbers,
    on_A: Numbers,
    on_B: Numbers,
    force: Array,
    point: Array,
    speed: Array,
    ends: Array,
    total: Array,
    normal: Array,
    slip: Array,
) -> None:
    """Add contacts at points to what each foot feels, the last three arguments.

    Args:
        sample: the sample that each of m contacts belongs to, shape (m,); contacts of samples
            that are not among the n do not count.
        on_A: side of the foot that is body A, 0 left, 1 right; negative for no foot, shape (m,).
        on_B: likewise of body B, whose foot counts when both are feet, shape (m,).
        force: on body B in W [N], shape (3 m,).
        point: where, in W [m], shape (3 m,).
        speed: at which it slips [m/s], shape (m,).
        ends: heels and toes in n samples, shape (n, 2, 2, 3); the nearer one bears the contact.
        total: force on each foot, shape (n, 2, 3).
        normal: vertical force on heel and toe, shape (n, 2, 2).
        slip: fastest speed of each foot, shape (n, 2).
    """
    for k in range(len(sample)):
        i, foot, sign = sample[k], on_B[k], 1.0
        if foot < 0:
            foot, sign = on_A[k], -1.0
        if foot < 0 or i < 0 or i >= len(ends):
            continue
        ahead = 0.0  # of the middle, along the line
        for j in range(3):
            heel, toe = ends[i, foot, 0, j], ends[i, foot, 1, j]
            ahead += (toe - heel) * (point[3 * k + j] - 0.5 * (heel + toe))
            total[i, foot, j] += sign * force[3 * k + j]
        normal[i, foot, int(ahead > 0.0)] += sign * force[3 * k + 2]
        slip[i, foot] = max(slip[i, foot], speed[k])


@compiled
def planned_motion(
    t: Array,
    k: Numbers,
    knots: Array,
    states: Array,
    r_G: Array,
    force: Array,
    moment: Array,
    mass: float,
    g: Array,
) -> tuple[Array, Array]:
    """Return a centroidal plan at n times, held at its end.

    Args:
        t: times [s], shape (n,).
        k: interval that contains each time, shape (n,).
        knots: times of the knots [s], shape (K + 1,).
        states: at the knots, ``[r, r', L_G, eta]`` of (36), shape (K + 1, 12).
        r_G: the fixed point of L_G [m], shape (3,).
        force: of all contacts in each interval [N], shape (K, 3).
        moment: likewise, about r_G [N m], shape (K, 3).
        mass: [kg].
        g: gravity [m/s^2], shape (3,).

    Returns:
        (motion, eta): CoM, velocity, acceleration, angular momentum about the CoM and its rate,
        shape (5, n, 3); eta, evenly between two knots, shape (n, 3).
    """
    n, end = len(t), knots[-1]
    motion, eta = np.empty((5, n, 3)), np.empty((n, 3))
    for i in range(n):
        j = k[i]
        tau = min(t[i], end) - knots[j]
        motion[:, i] = motion_under_force(tau, states[j], r_G, force[j], moment[j], mass, g)
        share = tau / (knots[j + 1] - knots[j])
        for axis in range(9, 12):
            eta[i, axis - 9] = (1.0 - share) * states[j, axis] + share * states[j + 1, axis]
    return motion, eta
