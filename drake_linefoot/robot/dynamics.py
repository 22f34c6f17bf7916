"""Rigid-body and centroidal quantities of one state, computed once and shared."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.tree import JacobianWrtVariable

from drake_linefoot.math.so3 import cross, skew
from drake_linefoot.robot.humanoid import Humanoid

if TYPE_CHECKING:
    from pydrake.systems.framework import Context

Array = NDArray[np.float64]

GRAVITY = np.array([0.0, 0.0, -9.81])  # [m/s^2], Drake's default
_WORLD_UP = np.array([0.0, 0.0, 1.0])


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
        feet: left and right.
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
    feet: tuple[FootMotion, FootMotion]

    @property
    def L_G(self) -> Array:
        """Angular momentum about the CoM [kg m^2/s], shape (3,)."""
        return self.A[:3] @ self.v


def contact_frame(R_WF: Array) -> Array:
    """Return R_WC: x along the foot's x axis, y level, z completing it.

    Args:
        R_WF: foot orientation, shape (3, 3).

    Returns:
        Shape (3, 3).

    Raises:
        ValueError: the foot's line stands upright, so that it has no heading.
    """
    x0, x1, x2 = R_WF[:, 0].tolist()
    norm = math.hypot(x0, x1)
    if norm < 1e-9:
        raise ValueError("the contact line stands upright: it has no heading")
    y0, y1 = -x1 / norm, x0 / norm
    # Columns x, y and x cross y.
    return np.array([[x0, y0, -x2 * y1], [x1, y1, x2 * y0], [x2, 0.0, x0 * y1 - x1 * y0]])


def centroidal_matrix(M: Array, r: Array) -> Array:
    """Return the centroidal momentum matrix from the six base rows of `M`.

    Args:
        M: mass matrix of a floating base whose velocity starts at 0, shape (..., nv, nv).
        r: CoM relative to the base origin in world [m], shape (..., 3).

    Returns:
        Angular rows about the CoM over linear rows, shape (..., 6, nv).
    """
    A = M[..., :6, :].copy()
    A[..., :3, :] -= skew(r) @ M[..., 3:6, :]
    return A


def foot_motion(humanoid: Humanoid, context: Context, side: int, v: Array) -> FootMotion:
    """Return the motion of one contact line; positions and velocities are in `context`.

    Args:
        humanoid: the robot.
        context: context of `humanoid.plant`.
        side: 0 left, 1 right.
        v: the velocities that are in `context`, shape (nv,).
    """
    plant = humanoid.plant
    frame, p_FC = humanoid.foot_frames[side], humanoid.p_FC[side]
    W = plant.world_frame()
    X_WF = frame.CalcPoseInWorld(context).GetAsMatrix34()
    R_WF = X_WF[:, :3]
    R_WC = contact_frame(R_WF)
    args = (context, JacobianWrtVariable.kV, frame, p_FC, W, W)
    J6 = plant.CalcJacobianSpatialVelocity(*args)
    bias = plant.CalcBiasSpatialAcceleration(*args).get_coeffs()
    project = R_WC[:, 1:].T  # A_s' R_i of (51)
    J, Jdot_v = np.empty((5, len(v))), np.empty(5)
    J[:3], Jdot_v[:3] = J6[3:], bias[3:]
    J[3:], Jdot_v[3:] = project @ J6[:3], project @ bias[:3]
    V = J6 @ v
    return FootMotion(
        p_WC=R_WF @ p_FC + X_WF[:, 3], R_WC=R_WC, v_WC=V[3:], w_WF=V[:3], J=J, Jdot_v=Jdot_v
    )


def robot_dynamics(humanoid: Humanoid, context: Context, x: Array) -> RobotDynamics:
    """Compute everything the controller needs from the state.

    Args:
        humanoid: the robot.
        context: scratch context of `humanoid.plant`; its state is overwritten.
        x: state [q, v], shape (nq + nv,).

    Returns:
        The quantities; arrays are fresh.
    """
    plant = humanoid.plant
    plant.SetPositionsAndVelocities(context, x)
    q, v = x[: humanoid.nq], x[humanoid.nq :]
    M = plant.CalcMassMatrix(context)
    Cv = plant.CalcBiasTerm(context)
    p_WG = plant.CalcCenterOfMassPositionInWorld(context)
    p_WB = q[4:7]
    r = p_WG - p_WB
    A = centroidal_matrix(M, r)
    Adot_v = Cv[:6].copy()
    Adot_v[:3] -= cross(r, Cv[3:6])
    return RobotDynamics(
        q=q,
        v=v,
        M=M,
        Cv=Cv,
        tau_g=GRAVITY @ M[3:6],
        R_WB=humanoid.base_rotation(q),
        p_WB=p_WB,
        p_WG=p_WG,
        v_WG=A[3:] @ v / humanoid.mass,
        A=A,
        Adot_v=Adot_v,
        feet=(foot_motion(humanoid, context, 0, v), foot_motion(humanoid, context, 1, v)),
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


def locked_inertia(A: Array, R_WB: Array) -> Array:
    """Return I_B of (23), the inertia about the CoM with all joints locked, in B.

    Args:
        A: centroidal momentum matrix, shape (..., 6, nv).
        R_WB: torso orientation, shape (..., 3, 3).

    Returns:
        [kg m^2], shape (..., 3, 3).
    """
    return np.swapaxes(R_WB, -1, -2) @ A[..., :3, :3] @ R_WB
