"""How far a knee bends on its side of the straight leg."""

import numpy as np
from scipy.optimize import brentq

from drake_linefoot.robot.leg_kinematics import leg_jacobian
from drake_linefoot.robot.legs import Legs
from drake_linefoot.types import Array

WAY = 100  # angles that are tried on the way to a limit
BEYOND = 1e-6  # [-] of the determinant in the given posture: one so far below 0 is no rounding


def knee_range(legs: Legs, leg: int, q: Array, knee: int) -> tuple[float, float]:
    """Return how far a knee bends without passing the straight leg, where the Jacobian is singular.

    Args:
        legs: both legs.
        leg: which of them.
        q: its joint angles, bent, between its limits [rad], shape (j,).
        knee: its place in the leg.

    Returns:
        (lower, upper): angles of the knee between its limits [rad], the other joints as they are.
    """

    def determinant(angle: float) -> float:
        moved = q.copy()
        moved[knee] = angle
        return float(np.linalg.det(leg_jacobian(legs, leg, moved)))

    now, ends = determinant(q[knee]), []

    def bent(angle: float) -> float:
        """Return the determinant by that of the given posture, negative beyond the straight leg."""
        return determinant(angle) / now

    for limit in (legs.lower[leg, knee], legs.upper[leg, knee]):
        way = np.linspace(q[knee], limit, WAY)
        beyond = [angle for angle in way if bent(angle) < -BEYOND]
        ends.append(brentq(bent, q[knee], beyond[0]) if beyond else limit)
    return float(ends[0]), float(ends[1])
