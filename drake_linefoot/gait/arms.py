"""Arms that swing against the legs: what those turn the robot about z, they turn back."""

import math

import numpy as np

from drake_linefoot.math.compiled import compiled
from drake_linefoot.types import Array


@compiled
def arm_motion(swing: float, contact: Array, feet: Array, targets: Array, yaw: float) -> Array:
    """Return how far the shoulders turn: angle, rate and acceleration [rad, s], shape (3,).

    Args:
        swing: angle by how far the right foot is ahead of the left one [rad/m].
        contact: 1 for a foot that stands, shape (2,).
        feet: where those stand [m], x, y first, shape (2, 4).
        targets: rows of the `SwingTarget` of the others, shape (2, 6, 3).
        yaw: heading [rad].
    """
    ahead, motion = np.array((math.cos(yaw), math.sin(yaw))), np.zeros(3)
    for foot in range(2):
        sign = swing if foot else -swing
        for j in range(2):
            if contact[foot] > 0.5:
                motion[0] += sign * ahead[j] * feet[foot, j]
            else:
                for i in range(3):
                    motion[i] += sign * ahead[j] * targets[foot, i, j]
    return motion
