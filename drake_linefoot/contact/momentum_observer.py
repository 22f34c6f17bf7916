"""The momentum-based disturbance observer, (19)-(21)."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.contact.kernels import coriolis_transpose, momentum_and_rate, moved_positions
from drake_linefoot.robot.dynamics import RobotDynamics
from drake_linefoot.robot.humanoid import Humanoid

if TYPE_CHECKING:
    from pydrake.systems.framework import Context

Array = NDArray[np.float64]

_STEP = 1e-8  # [s] of the difference; its error is below 1e-6 of the result


class MomentumTerms(NamedTuple):
    """What (20) needs of one state.

    Attributes:
        momentum: p = M v, shape (nv,).
        known: C'v + tau_g, the part of its rate that is neither torque nor contact, (nv,).
    """

    momentum: Array
    known: Array


def coriolis_transpose_velocity(
    humanoid: Humanoid, scratch: Context, q: Array, v: Array, M: Array, Cv: Array
) -> Array:
    """Return C(q, v)' v = Mdot v - C v for any C with Mdot = C + C', below (19).

    Mdot v is a difference of the mass matrix along the motion.

    Args:
        humanoid: the robot.
        scratch: context of its plant; overwritten.
        q: positions, shape (nq,).
        v: velocities, shape (nv,).
        M: mass matrix, shape (nv, nv).
        Cv: Coriolis and centrifugal forces, shape (nv,).

    Returns:
        Shape (nv,).
    """
    return coriolis_transpose(_mass_matrix_after(humanoid, scratch, q, v), M, _STEP, v, Cv)


def momentum_terms(humanoid: Humanoid, scratch: Context, dynamics: RobotDynamics) -> MomentumTerms:
    """Return momentum and the known part of its rate.

    Args:
        humanoid: the robot.
        scratch: context of its plant; overwritten.
        dynamics: quantities of the state.
    """
    d = dynamics
    after = _mass_matrix_after(humanoid, scratch, d.q, d.v)
    return MomentumTerms(*momentum_and_rate(after, d.M, _STEP, d.v, d.Cv, d.tau_g))


def _mass_matrix_after(humanoid: Humanoid, scratch: Context, q: Array, v: Array) -> Array:
    """Return the mass matrix `_STEP` later at constant velocity."""
    humanoid.plant.SetPositions(scratch, moved_positions(q, v, _STEP))
    after: Array = humanoid.plant.CalcMassMatrix(scratch).T  # symmetric; in the order of rows
    return after
