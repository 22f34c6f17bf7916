"""Contact wrenches from the generalized force of the observer: pseudoinverse, or (22)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.contact.cone_program import ConeProgram
from drake_linefoot.contact.kernels import flag, least_squares_wrench
from drake_linefoot.contact.wrench_cone import world_cone
from drake_linefoot.errors import SolverError

Array = NDArray[np.float64]

_RHO = 1e-2  # [-] the smallest curvature of the scaled cost
RANK_TOLERANCE = 1e-10  # [-] below it Jacobians of both feet are not independent


def estimate_wrenches(residual: Array, J: Array) -> Array:
    """Return the wrenches that explain the residual best, f = pinv(J') tau_d.

    Args:
        residual: generalized force of all contacts, shape (nv,).
        J: line-contact Jacobians (51) of both feet, shape (2, 5, nv).

    Returns:
        Wrench of each foot, shape (2, 5).
    """
    rows = J.reshape(-1, J.shape[-1])
    wrench, independent = least_squares_wrench(residual, rows, RANK_TOLERANCE)
    if not independent:
        wrench[:] = np.linalg.lstsq(rows.T, residual, rcond=RANK_TOLERANCE)[0]
    return wrench.reshape(2, 5)


class ConstrainedEstimate:
    """The estimate (22): the best explanation that friction allows."""

    def __init__(self, mu: float, mass: float, half_length: float) -> None:
        """Keep the constants; `mass` [kg], `half_length` X [m]."""
        self._mu, self._X = mu, half_length
        weight = mass * 9.81
        self._units = np.array([weight] * 3 + [weight * half_length] * 2)
        self._program = ConeProgram("osqp", 1e-8, 4000, _RHO)

    def solve(self, residual: Array, J: Array, R_WC: Array) -> Array:
        """Return the wrenches.

        Args:
            residual: generalized force of all contacts, shape (nv,).
            J: line-contact Jacobians of both feet, shape (2, 5, nv).
            R_WC: contact frames, shape (2, 3, 3).

        Returns:
            Wrench of each foot, inside its cone, shape (2, 5).

        Raises:
            SolverError: the program is not solved.
        """
        scaled = (J * self._units[:, None]).reshape(-1, J.shape[-1])
        H, g = scaled @ scaled.T, -(scaled @ residual)
        cost_scale = max(float(np.diagonal(H).max()), 1e-12)
        W = np.stack([world_cone(self._mu, self._X, R) for R in R_WC])
        W[:, 2:] /= self._X
        W = W * self._units / self._units[0]
        solution = self._program.solve(H / cost_scale, g / cost_scale, W, np.zeros((2, 6)))
        if not solution.success:
            raise SolverError("contact", solution.status)
        return solution.z.reshape(2, 5) * self._units


def initial_state(momentum: Array, J: Array, mass: float) -> Array:
    """Return the state of an estimator that begins with both feet under half the weight.

    Args:
        momentum: p = M v, shape (nv,).
        J: Jacobians of both feet, shape (2, 5, nv).
        mass: of the robot [kg].

    Returns:
        Momentum, residual, wrenches and flags, as in `kernels.next_estimate`, shape (2 nv + 12,).
    """
    wrench = np.zeros((2, 5))
    wrench[:, 2] = 0.5 * mass * 9.81
    residual = np.einsum("fij,fi->j", J, wrench)
    return np.concatenate([momentum, residual, wrench.ravel(), np.ones(2)])


def contact_flags(
    normal_force: Array, before: tuple[bool, bool], touch: float, release: float
) -> tuple[bool, bool]:
    """Return which feet stand, with hysteresis.

    Args:
        normal_force: vertical force of each foot [N], shape (2,).
        before: flags of the last tick.
        touch: force above which a foot in the air counts as standing [N].
        release: force below which a standing foot counts as in the air [N].
    """
    left, right = (
        flag(force, stood, touch, release)
        for force, stood in zip(normal_force.tolist(), before, strict=True)
    )
    return left, right
