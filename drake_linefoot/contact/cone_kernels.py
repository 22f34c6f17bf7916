"""Compiled: cones of line contacts on ground that is not level."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.math.compiled import compiled

Array = NDArray[np.float64]

LEVEL = np.zeros(2)  # slope of level ground


@compiled
def turn_across(R_WC: Array, slope: Array) -> tuple[float, float]:
    """Return cosine and sine of the turn about the line, from its frame C to the ground's.

    The line tells the slope along it, its frame has y level. Across the line the ground may
    rise as well, so its normal is turned against that of C.

    Args:
        R_WC: contact frame, shape (3, 3).
        slope: of the ground, rise per metre along x and y of the world, shape (2,).
    """
    # The normal (-s_x, -s_y, 1) in C; what it has along the line is the line's own affair.
    across = R_WC[2, 1] - slope[0] * R_WC[0, 1] - slope[1] * R_WC[1, 1]
    up = R_WC[2, 2] - slope[0] * R_WC[0, 2] - slope[1] * R_WC[1, 2]
    size = math.hypot(across, up)
    return up / size, -across / size


@compiled
def ground_frame(R_WC: Array, slope: Array) -> Array:
    """Return the frame of the ground under a line: C turned about the line, shape (3, 3).

    Args:
        R_WC: contact frame, shape (3, 3).
        slope: of the ground, rise per metre along x and y of the world, shape (2,).
    """
    c, s = turn_across(R_WC, slope)
    R = np.empty((3, 3))
    R[:, 0] = R_WC[:, 0]
    R[:, 1] = c * R_WC[:, 1] + s * R_WC[:, 2]
    R[:, 2] = c * R_WC[:, 2] - s * R_WC[:, 1]
    return R


@compiled
def turned_cone(cone: Array, R_WC: Array, slope: Array, out: Array) -> None:
    """Write the rows of a cone for a wrench with forces in W and torques in C.

    Args:
        cone: rows in the frame of the ground, shape (n, 5).
        R_WC: contact frame, shape (3, 3).
        slope: of the ground, rise per metre along x and y of the world, shape (2,).
        out: becomes the rows, shape (n, 5).
    """
    c, s = turn_across(R_WC, slope)
    for i in range(len(cone)):
        x = cone[i, 0]
        y, z = c * cone[i, 1] - s * cone[i, 2], s * cone[i, 1] + c * cone[i, 2]
        for j in range(3):
            out[i, j] = x * R_WC[j, 0] + y * R_WC[j, 1] + z * R_WC[j, 2]
        out[i, 3] = c * cone[i, 3] - s * cone[i, 4]
        out[i, 4] = s * cone[i, 3] + c * cone[i, 4]


@compiled
def turned_cones(cone: Array, R_WC: Array, slope: Array) -> Array:
    """Return `turned_cone` of many contact frames, shapes (m, 3, 3) and (m, n, 5)."""
    out = np.empty((len(R_WC), len(cone), 5))
    for k in range(len(R_WC)):
        turned_cone(cone, R_WC[k], slope, out[k])
    return out
