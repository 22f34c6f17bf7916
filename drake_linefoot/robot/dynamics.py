"""Rigid-body and centroidal quantities of one state, computed once and shared."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.tree import JacobianWrtVariable

from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.kernels import base_terms, line_motion

if TYPE_CHECKING:
    from pydrake.systems.framework import Context

Array = NDArray[np.float64]

GRAVITY = np.array([0.0, 0.0, -9.81])  # [m/s^2], Drake's default


@dataclass(frozen=True)
class FootMotion:
    """Motion of a contact line. C is its middle; frame C has x along the line.

    Attributes:
        p_WC: middle of the line [m], shape (3,).
        R_WC: x along the line, y level, z up, shape (3, 3); for a flat foot on level
            ground z is the ground normal, whatever the roll of the leg about the line.
        v_WC: velocity of the middle [m/s], shape (3,).
        w_WF: angular velocity of the foot in world [rad/s], shape (3,).
        J: line-contact Jacobian (51), rows (v_WC, [w_y, w_z] in C), shape (5, nv).
        Jdot_v: bias of these five accelerations, shape (5,).
    """

    p_WC: Array
    R_WC: Array
    v_WC: Array
    w_WF: Array
    J: Array
    Jdot_v: Array


@dataclass(frozen=True)
class RobotDynamics:
    """What the controller needs to know of one state.

    The equation of motion is ``M vdot + Cv = tau_g + S' tau + sum J_i' w_i``.

    Attributes:
        q: positions, shape (nq,).
        v: velocities, shape (nv,).
        M: mass matrix with reflected inertias, shape (nv, nv).
        Cv: Coriolis and centrifugal forces, shape (nv,).
        tau_g: generalized gravity forces, shape (nv,).
        R_WB: torso orientation, shape (3, 3).
        p_WB: torso origin [m], shape (3,).
        p_WG: centre of mass [m], shape (3,).
        v_WG: its velocity [m/s], shape (3,).
        A: centroidal momentum matrix, angular about G over linear, shape (6, nv).
        Adot_v: its bias, rate of (angular, linear) momentum at vdot = 0, shape (6,).
        J: line-contact Jacobians (51) of both feet, shape (2, 5, nv).
        R_WC: contact frames of both feet, shape (2, 3, 3).
        feet: left and right; what a line has of `J` and `R_WC` is its part of them.
    """

    q: Array
    v: Array
    M: Array
    Cv: Array
    tau_g: Array
    R_WB: Array
    p_WB: Array
    p_WG: Array
    v_WG: Array
    A: Array
    Adot_v: Array
    J: Array
    R_WC: Array
    feet: tuple[FootMotion, FootMotion]

    @property
    def L_G(self) -> Array:
        """Angular momentum about the CoM [kg m^2/s], shape (3,)."""
        return self.A[:3] @ self.v


def foot_motion(
    humanoid: Humanoid, context: Context, side: int, v: Array, J: Array, R_WC: Array
) -> FootMotion:
    """Return the motion of one contact line; positions and velocities are in `context`.

    Args:
        humanoid: the robot.
        context: context of `humanoid.plant`.
        side: 0 left, 1 right.
        v: the velocities that are in `context`, shape (nv,).
        J: becomes the line-contact Jacobian, shape (5, nv).
        R_WC: becomes the contact frame, shape (3, 3).

    Raises:
        ValueError: the line stands upright, so that it has no heading.
    """
    plant = humanoid.plant
    frame, p_FC, W = humanoid.foot_frames[side], humanoid.p_FC[side], humanoid.world
    X_WF = frame.CalcPoseInWorld(context).GetAsMatrix34()
    args = (context, JacobianWrtVariable.kV, frame, p_FC, W, W)
    J_V = plant.CalcJacobianSpatialVelocity(*args)
    bias = plant.CalcBiasSpatialAcceleration(*args).get_coeffs()
    p_WC, V, Jdot_v = np.empty(3), np.empty(6), np.empty(5)
    line_motion(X_WF, p_FC, J_V, bias, v, p_WC, R_WC, V, J, Jdot_v)
    return FootMotion(p_WC=p_WC, R_WC=R_WC, v_WC=V[3:], w_WF=V[:3], J=J, Jdot_v=Jdot_v)


def robot_dynamics(humanoid: Humanoid, context: Context, x: Array) -> RobotDynamics:
    """Compute everything the controller needs from the state.

    Args:
        humanoid: the robot.
        context: scratch context of `humanoid.plant`; its state is overwritten.
        x: state [q, v], shape (nq + nv,).

    Returns:
        The quantities; arrays are fresh.

    Raises:
        ValueError: the line of a foot stands upright.
    """
    plant = humanoid.plant
    plant.SetPositionsAndVelocities(context, x)
    q, v = x[: humanoid.nq], x[humanoid.nq :]
    M = plant.CalcMassMatrix(context).T  # symmetric; in the order of rows
    Cv = plant.CalcBiasTerm(context)
    p_WG = plant.CalcCenterOfMassPositionInWorld(context)
    p_WB = q[4:7]
    nv = len(v)
    A, Adot_v, tau_g, v_WG = np.empty((6, nv)), np.empty(6), np.empty(nv), np.empty(3)
    base_terms(M, Cv, p_WG - p_WB, v, GRAVITY, A, Adot_v, tau_g, v_WG)
    J, R_WC = np.empty((2, 5, nv)), np.empty((2, 3, 3))
    left = foot_motion(humanoid, context, 0, v, J[0], R_WC[0])
    right = foot_motion(humanoid, context, 1, v, J[1], R_WC[1])
    return RobotDynamics(
        q=q,
        v=v,
        M=M,
        Cv=Cv,
        tau_g=tau_g,
        R_WB=humanoid.base_rotation(q),
        p_WB=p_WB,
        p_WG=p_WG,
        v_WG=v_WG,
        A=A,
        Adot_v=Adot_v,
        J=J,
        R_WC=R_WC,
        feet=(left, right),
    )


class SharedDynamics:
    """`robot_dynamics` for blocks that ask for the same state one after the other.

    The estimator and the gait see a state at the end of a tick, controller and recorder at
    the beginning of the next: it is computed once.
    """

    def __init__(self, humanoid: Humanoid) -> None:
        """Allocate the scratch context."""
        self._humanoid = humanoid
        self._context = humanoid.plant.CreateDefaultContext()
        self._key = b""
        self._value: RobotDynamics | None = None

    def __call__(self, x: Array) -> RobotDynamics:
        """Return the quantities of a state [q, v], shape (nq + nv,); not to be changed."""
        key = x.tobytes()
        if self._value is None or key != self._key:
            self._value = robot_dynamics(self._humanoid, self._context, x.copy())
            self._key = key
        return self._value
