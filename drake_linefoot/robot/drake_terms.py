"""The rigid-body dynamics of a state by Drake's calls: for a robot that is no tree of our own."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.tree import JacobianWrtVariable

from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.types import Array

if TYPE_CHECKING:
    from pydrake.systems.framework import Context

STEP = 1e-6  # [s] of a central difference; its error is below 1e-8 of the result


class Terms(NamedTuple):
    """What all other quantities of a state follow from.

    Attributes:
        M: mass matrix with reflected inertias, shape (nv, nv).
        Cv: Coriolis and centrifugal forces, shape (nv,).
        CTv: C'v, below (19), shape (nv,).
        X_WF: axes of each foot beside the middle of its line [m], shape (2, 3, 4).
        J_V: Jacobians of their spatial velocities there, angular over linear, shape (2, 6, nv).
        bias: biases of those velocities' rates, shape (2, 6).
    """

    M: Array
    Cv: Array
    CTv: Array
    X_WF: Array
    J_V: Array
    bias: Array


def drake_terms(humanoid: Humanoid, context: Context, x: Array) -> Terms:
    """Ask Drake for the terms of a state.

    C'v is Mdot v - C v, with a central difference of M along the motion.

    Args:
        humanoid: the robot.
        context: of its plant; its state is overwritten.
        x: state [q, v], shape (nq + nv,).
    """
    plant, W, nq = humanoid.plant, humanoid.world, humanoid.nq
    plant.SetPositionsAndVelocities(context, x)
    M, Cv = plant.CalcMassMatrix(context), plant.CalcBiasTerm(context)
    X_WF, J_V, bias = [], [], []
    for frame, p_FC in zip(humanoid.foot_frames, humanoid.p_FC, strict=True):
        args = context, JacobianWrtVariable.kV, frame, p_FC, W, W
        X_WF.append((frame.CalcPoseInWorld(context) @ RigidTransform(p_FC)).GetAsMatrix34())
        J_V.append(plant.CalcJacobianSpatialVelocity(*args))
        bias.append(plant.CalcBiasSpatialAcceleration(*args).get_coeffs())
    qdot, near = plant.MapVelocityToQDot(context, x[nq:]), []
    for step in (STEP, -STEP):
        plant.SetPositions(context, x[:nq] + step * qdot)
        near.append(plant.CalcMassMatrix(context))
    CTv = (near[0] - near[1]) @ x[nq:] / (2.0 * STEP) - Cv
    plant.SetPositions(context, x[:nq])
    return Terms(M.T.copy(), Cv, CTv, np.array(X_WF), np.array(J_V), np.array(bias))
