"""The momentum-based disturbance observer, (19)-(21)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from drake_linefoot.math.compiled import compiled, inlined
from drake_linefoot.robot.dynamics import RobotDynamics
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.types import Array

if TYPE_CHECKING:
    from pydrake.systems.framework import Context

STEP = 1e-8  # [s] of the difference; its error is below 1e-6 of the result


def mass_matrix_after(humanoid: Humanoid, scratch: Context, q: Array, v: Array) -> Array:
    """Return the mass matrix `STEP` later at constant velocity, shape (nv, nv).

    Args:
        humanoid: the robot.
        scratch: context of its plant; overwritten.
        q: positions, shape (nq,).
        v: velocities, shape (nv,).
    """
    humanoid.plant.SetPositions(scratch, moved_positions(q, v, STEP))
    after: Array = humanoid.plant.CalcMassMatrix(scratch).T  # symmetric; in the order of rows
    return after


@compiled
def moved_positions(q: Array, v: Array, step: float) -> Array:
    """Return positions a short time later, at constant velocity.

    Args:
        q: positions of a floating base, quaternion first, with a joint for each further
            velocity, shape (nv + 1,).
        v: velocities, angular velocity of the base first, shape (nv,).
        step: the time [s].

    Returns:
        Shape (nv + 1,); the quaternion is not of unit length.
    """
    rate = np.empty(len(q))
    w, x, y, z = 0.5 * q[0], 0.5 * q[1], 0.5 * q[2], 0.5 * q[3]
    rate[0] = -x * v[0] - y * v[1] - z * v[2]
    rate[1] = w * v[0] + z * v[1] - y * v[2]
    rate[2] = -z * v[0] + w * v[1] + x * v[2]
    rate[3] = y * v[0] - x * v[1] + w * v[2]
    rate[4:] = v[3:]
    return q + step * rate


@inlined
def coriolis_transpose(M_after: Array, M: Array, v: Array, Cv: Array) -> Array:
    """Return C'v = Mdot v - C v for any C with Mdot = C + C', below (19).

    Mdot v is a difference of the mass matrix along the motion.

    Args:
        M_after: mass matrix `STEP` later, see `mass_matrix_after`, shape (nv, nv).
        M: mass matrix, shape (nv, nv).
        v: velocities, shape (nv,).
        Cv: Coriolis and centrifugal forces, shape (nv,).

    Returns:
        Shape (nv,).
    """
    return (M_after - M) @ v / STEP - Cv


@inlined
def momentum_terms(d: RobotDynamics, M_after: Array) -> tuple[Array, Array]:
    """Return momentum and the part of its rate that is neither torque nor contact, (20).

    Args:
        d: quantities of the state.
        M_after: see `mass_matrix_after`, shape (nv, nv).

    Returns:
        (p, known): ``M v`` and ``C'v + tau_g``, shapes (nv,).
    """
    return d.M @ d.v, coriolis_transpose(M_after, d.M, d.v, d.Cv) + d.tau_g


@inlined
def update_residual(
    residual: Array, rate: Array, known: Array, actuation: Array, gamma: float
) -> Array:
    """Return tau_d of (21), the filtered generalized force of all contacts.

    Args:
        residual: the one of the last tick, shape (nv,).
        rate: of the momentum over the tick, shape (nv,).
        known: part of it that is neither torque nor contact, (20), shape (nv,).
        actuation: generalized force of the actuators over the tick, shape (nv,).
        gamma: filter constant, 0 <= gamma < 1.

    Returns:
        Shape (nv,).
    """
    return gamma * residual + (1.0 - gamma) * (rate - known - actuation)
