"""Contact wrenches from the generalized force of the observer: pseudoinverse, or (22)."""

import numpy as np

from drake_linefoot.constants import STANDARD_GRAVITY
from drake_linefoot.contact.cone_program import ConeProgram
from drake_linefoot.contact.contacts import Contact
from drake_linefoot.contact.wrench_cone import LEVEL, world_cones
from drake_linefoot.errors import SolverError
from drake_linefoot.math.compiled import inlined
from drake_linefoot.math.linear import orthonormal_rows
from drake_linefoot.types import Array

_RHO = 1e-2  # [-] the smallest curvature of the scaled cost
RANK_TOLERANCE = 1e-10  # [-] a row of a Jacobian that others leave less of depends on them


@inlined
def estimate_wrenches(residual: Array, J: Array) -> Array:
    """Return the wrenches that explain the residual best, f = pinv(J') tau_d.

    A row that depends on rows above it explains nothing, and gets nothing.

    Args:
        residual: generalized force of all contacts, shape (nv,).
        J: contact Jacobians (51) of both feet, shape (2, nw, nv).

    Returns:
        Wrench of each foot, shape (2, nw).
    """
    rows = J.reshape(-1, J.shape[-1])
    Q, R, kept = orthonormal_rows(rows, RANK_TOLERANCE)
    f = Q @ residual
    for i in range(len(f) - 1, -1, -1):  # R'f = Q residual
        for j in range(i + 1, len(f)):
            f[i] -= R[j, i] * f[j]
        f[i] = f[i] / R[i, i] if kept[i] else 0.0
    return f.reshape(2, J.shape[1])


class ConstrainedEstimate:
    """The estimate (22): the best explanation that friction allows."""

    def __init__(self, mass: float, contact: Contact) -> None:
        """Keep the constants; `mass` [kg], `contact` of the feet."""
        self._contact, self._units = contact, contact.units(mass)
        self._program = ConeProgram("osqp", 1e-8, 4000, _RHO)

    def solve(self, residual: Array, J: Array, R_WC: Array, mu: float) -> Array:
        """Return the wrenches.

        Args:
            residual: generalized force of all contacts, shape (nv,).
            J: contact Jacobians of both feet, shape (2, nw, nv).
            R_WC: contact frames, shape (2, 3, 3).
            mu: friction in the cones [-].

        Returns:
            Wrench of each foot, inside its cone, shape (2, nw).

        Raises:
            SolverError: the program is not solved.
        """
        scaled = (J * self._units[:, None]).reshape(-1, J.shape[-1])
        H, g = scaled @ scaled.T, -(scaled @ residual)
        cost_scale = max(float(np.diagonal(H).max()), 1e-12)
        level = np.tile(LEVEL, (len(R_WC), 1))
        W = world_cones(self._contact.cone(mu), R_WC, level) * self._units / self._units[0]
        solution = self._program.solve(H / cost_scale, g / cost_scale, W, np.zeros(W.shape[:2]))
        if not solution.success:
            raise SolverError("contact", solution.status.words)
        return solution.z.reshape(2, -1) * self._units


def half_the_weight(mass: float, size: int) -> Array:
    """Return the wrenches of two feet that carry half the weight each, shape (2, size)."""
    wrench = np.zeros((2, size))
    wrench[:, 2] = 0.5 * mass * STANDARD_GRAVITY
    return wrench


@inlined
def contact_flags(normal_force: Array, before: Array, touch: float, release: float) -> Array:
    """Return which feet stand, with hysteresis.

    Args:
        normal_force: vertical force of each foot [N], shape (2,).
        before: flags of the last tick, 0 or 1, shape (2,).
        touch: force above which a foot in the air counts as standing [N].
        release: force below which a standing foot counts as in the air [N].

    Returns:
        Flags, 0 or 1, shape (2,).
    """
    flags = np.zeros(2)
    for foot in range(2):
        threshold = release if before[foot] > 0.5 else touch
        flags[foot] = 1.0 if normal_force[foot] > threshold else 0.0
    return flags
