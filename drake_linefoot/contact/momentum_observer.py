"""The momentum-based disturbance observer, (19)-(21)."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.contact.kernels import coriolis_transpose, moved_positions
from drake_linefoot.robot.dynamics import RobotDynamics
from drake_linefoot.robot.humanoid import Humanoid

if TYPE_CHECKING:
    from pydrake.systems.framework import Context

Array = NDArray[np.float64]

_STEP = 1e-6  # [s] of the central difference; its error is below 1e-9 of the result


class MomentumTerms(NamedTuple):
    """What (20) needs of one state.

    Attributes:
        momentum: p = M v, shape (nv,).
        known: C'v + tau_g, the part of its rate that is neither torque nor contact, (nv,).
    """

    momentum: Array
    known: Array


def coriolis_transpose_velocity(
    humanoid: Humanoid, scratch: Context, q: Array, v: Array, Cv: Array
) -> Array:
    """Return C(q, v)' v = Mdot v - C v for any C with Mdot = C + C', below (19).

    Mdot v is a central difference of the mass matrix along the motion.

    Args:
        humanoid: the robot.
        scratch: context of its plant; overwritten.
        q: positions, shape (nq,).
        v: velocities, shape (nv,).
        Cv: Coriolis and centrifugal forces, shape (nv,).

    Returns:
        Shape (nv,).
    """
    plant = humanoid.plant
    q_after, q_before = moved_positions(q, v, _STEP)
    plant.SetPositions(scratch, q_after)
    after = plant.CalcMassMatrix(scratch).T  # symmetric; in the order of rows
    plant.SetPositions(scratch, q_before)
    before = plant.CalcMassMatrix(scratch).T
    return coriolis_transpose(after, before, _STEP, v, Cv)


def momentum_terms(humanoid: Humanoid, scratch: Context, dynamics: RobotDynamics) -> MomentumTerms:
    """Return momentum and the known part of its rate.

    Args:
        humanoid: the robot.
        scratch: context of its plant; overwritten.
        dynamics: quantities of the state.
    """
    d = dynamics
    known = coriolis_transpose_velocity(humanoid, scratch, d.q, d.v, d.Cv)
    return MomentumTerms(d.M @ d.v, known + d.tau_g)
