"""How far a knee bends on its side of the straight leg."""

import numpy as np
from scipy.optimize import brentq

from drake_linefoot.robot.leg_kinematics import contact_jacobian, contact_point
from drake_linefoot.robot.legs import Legs, chain, new_links
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

    def bent(angle: float) -> float:
        """Return the determinant, negative beyond the straight leg."""
        n = len(legs.zeros)
        links, p, J, E, moved = new_links(legs), np.empty(3), np.empty((6, n)), np.eye(n), q.copy()
        moved[knee] = angle
        chain(legs, leg, moved, links)
        contact_point(legs, leg, links, p, J)
        contact_jacobian(legs.zeros, links.R[n], J, E)
        return float(np.linalg.det(E)) / now

    now, ends = 1.0, []
    now = bent(q[knee])
    for limit in (legs.lower[leg, knee], legs.upper[leg, knee]):
        way = np.linspace(q[knee], limit, WAY)
        beyond = [angle for angle in way if bent(angle) < -BEYOND]
        ends.append(brentq(bent, q[knee], beyond[0]) if beyond else limit)
    return float(ends[0]), float(ends[1])
