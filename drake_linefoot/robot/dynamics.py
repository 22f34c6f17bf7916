"""Rigid-body and centroidal quantities of one state: the terms of (1), momentum, contact lines."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from pydrake.multibody.tree import JacobianWrtVariable

from drake_linefoot.constants import GRAVITY
from drake_linefoot.math.compiled import compiled, inlined
from drake_linefoot.math.linear import dot
from drake_linefoot.math.rotation import cross, from_quaternion, skew
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.types import Array

if TYPE_CHECKING:
    from pydrake.systems.framework import Context

_BY_VELOCITY = JacobianWrtVariable.kV


class RobotDynamics(NamedTuple):
    """What the controller needs to know of one state; not to be changed.

    The equation of motion is ``M vdot + Cv = tau_g + S' tau + sum J_i' w_i``, (1). C is the middle
    of a foot's contact line; frame C has x along the line. Left before right.

    Attributes:
        q: positions, shape (nq,).
        v: velocities, shape (nv,).
        M: mass matrix with reflected inertias, shape (nv, nv).
        Cv: Coriolis and centrifugal forces, shape (nv,).
        tau_g: generalized gravity forces, shape (nv,).
        R_WB: torso orientation, shape (3, 3).
        p_WG: centre of mass [m], shape (3,).
        v_WG: its velocity [m/s], shape (3,).
        A: centroidal momentum matrix, angular about G over linear, shape (6, nv).
        Adot_v: rate of that momentum at vdot = 0, shape (6,).
        p_WC: middle of each contact line [m], shape (2, 3).
        R_WC: contact frames: x along the line, y level, z up; for a flat foot on level ground z
            is the ground normal, whatever the roll of the leg about the line, shape (2, 3, 3).
        v_WC: velocity of the middles [m/s], shape (2, 3).
        w_WF: angular velocity of the feet [rad/s], shape (2, 3).
        J: line-contact Jacobians (51), rows (v_WC, [w_y, w_z] in C), shape (2, 5, nv).
        Jdot_v: bias of these five accelerations, shape (2, 5).
    """

    q: Array
    v: Array
    M: Array
    Cv: Array
    tau_g: Array
    R_WB: Array
    p_WG: Array
    v_WG: Array
    A: Array
    Adot_v: Array
    p_WC: Array
    R_WC: Array
    v_WC: Array
    w_WF: Array
    J: Array
    Jdot_v: Array

    @property
    def p_WB(self) -> Array:
        """Torso origin [m], shape (3,)."""
        return self.q[4:7]

    @property
    def L_G(self) -> Array:
        """Angular momentum about the CoM [kg m^2/s], shape (3,)."""
        return self.A[:3] @ self.v

    def __deepcopy__(self, memo: dict[int, object]) -> RobotDynamics:
        """Return self; Drake copies abstract values on every update."""
        return self


def robot_dynamics(humanoid: Humanoid, context: Context, x: Array) -> RobotDynamics:
    """Compute everything the controller needs from the state.

    Args:
        humanoid: the robot.
        context: scratch context of `humanoid.plant`; its state is overwritten.
        x: state [q, v], shape (nq + nv,).

    Returns:
        The quantities; arrays are fresh, but for `q` and `v`, which are views of `x`.

    Raises:
        ValueError: the line of a foot stands upright.
    """
    plant, W, nv = humanoid.plant, humanoid.world, humanoid.nv
    plant.SetPositionsAndVelocities(context, x)
    X_WF, J_V, bias = [], [], []
    for side, frame in enumerate(humanoid.foot_frames):
        X_WF.append(frame.CalcPoseInWorld(context).GetAsMatrix34())
        args = context, _BY_VELOCITY, frame, humanoid.p_FC[side], W, W
        J_V.append(plant.CalcJacobianSpatialVelocity(*args))
        bias.append(plant.CalcBiasSpatialAcceleration(*args).get_coeffs())
    d = RobotDynamics(
        q=x[: humanoid.nq],
        v=x[humanoid.nq :],
        M=plant.CalcMassMatrix(context).T,  # symmetric; in the order of rows
        Cv=plant.CalcBiasTerm(context),
        tau_g=np.empty(nv),
        R_WB=np.empty((3, 3)),
        p_WG=humanoid.tree.com(context),
        v_WG=np.empty(3),
        A=np.empty((6, nv)),
        Adot_v=np.empty(6),
        p_WC=np.empty((2, 3)),
        R_WC=np.empty((2, 3, 3)),
        v_WC=np.empty((2, 3)),
        w_WF=np.empty((2, 3)),
        J=np.empty((2, 5, nv)),
        Jdot_v=np.empty((2, 5)),
    )
    complete(tuple(d), humanoid.p_FC, tuple(X_WF), tuple(J_V), tuple(bias))
    return d


@compiled
def complete(
    parts: tuple[Array, ...],
    p_FC: Array,
    X_WF: tuple[Array, ...],
    J_V: tuple[Array, ...],
    bias: tuple[Array, ...],
) -> None:
    """Fill in what follows from Drake's quantities of a state.

    Args:
        parts: of `RobotDynamics`, as a plain tuple, which Numba takes over faster: with q, v, M,
            Cv and p_WG; the others are written.
        p_FC: middle of each line in its foot [m], shape (2, 3).
        X_WF: poses of both feet, rotation beside origin, shapes (3, 4).
        J_V: Jacobians of the feet's spatial velocities at C, angular over linear, shapes (6, nv).
        bias: biases of those velocities' rates, shapes (6,).

    Raises:
        ValueError: the line of a foot stands upright.
    """
    d = RobotDynamics(*parts)
    d.R_WB[:] = from_quaternion(d.q)
    centroidal_terms(d)
    for side in range(2):
        line_motion(d, side, p_FC[side], X_WF[side], J_V[side], bias[side])


@inlined
def centroidal_terms(d: RobotDynamics) -> None:
    """Fill in what the six base rows of the dynamics say: A, Adot_v, tau_g and v_WG.

    The velocity of a floating base comes first in v, so these rows are the rates of momentum
    about the base origin.
    """
    r = d.p_WG - d.q[4:7]  # of the CoM from the base origin
    d.A[:3] = d.M[:3] - skew(r) @ d.M[3:6]
    d.A[3:] = d.M[3:6]
    d.Adot_v[:3] = d.Cv[:3] - cross(r, d.Cv[3:6])
    d.Adot_v[3:] = d.Cv[3:6]
    d.tau_g[:] = GRAVITY[2] * d.M[5]
    d.v_WG[:] = d.M[3:6] @ d.v / d.M[3, 3]  # of the diagonal mass block


@inlined
def line_motion(
    d: RobotDynamics, side: int, p_FC: Array, X_WF: Array, J_V: Array, bias: Array
) -> None:
    """Fill in the motion of one contact line, (51).

    Args:
        d: p_WC, R_WC, v_WC, w_WF, J and Jdot_v of the side are written.
        side: 0 left, 1 right.
        p_FC: middle of the line in the foot [m], shape (3,).
        X_WF: pose of the foot, shape (3, 4).
        J_V: Jacobian of the foot's spatial velocity at C, angular over linear, shape (6, nv).
        bias: bias of that velocity's rate, shape (6,).

    Raises:
        ValueError: the line stands upright.
    """
    R_WC = contact_frame(X_WF)
    d.R_WC[side] = R_WC
    # Loops, not `@`: the two feet would take 5 us more, which is 0.7 % of a tick of the loop.
    for i in range(3):
        d.p_WC[side, i] = X_WF[i, 3] + dot(X_WF[i, :3], p_FC)
        d.w_WF[side, i], d.v_WC[side, i] = dot(J_V[i], d.v), dot(J_V[3 + i], d.v)
        d.J[side, i], d.Jdot_v[side, i] = J_V[3 + i], bias[3 + i]
    for i in range(2):  # A_s' R_i of (51): y and z of the contact frame
        across = R_WC[:, 1 + i]
        d.Jdot_v[side, 3 + i] = dot(across, bias[:3])
        for j in range(len(d.v)):
            d.J[side, 3 + i, j] = dot(across, J_V[:3, j])


@inlined
def contact_frame(R_WF: Array) -> Array:
    """Return R_WC: x along the foot's x axis, y level, z completing it.

    Args:
        R_WF: foot orientation, shape (3, 3) or, with the origin beside it, (3, 4).

    Returns:
        Shape (3, 3).

    Raises:
        ValueError: the foot's line stands upright, so that it has no heading.
    """
    R_WC = np.zeros((3, 3))
    x = R_WF[:, 0]
    norm = math.hypot(x[0], x[1])
    if norm < 1e-9:
        raise ValueError("the contact line stands upright: it has no heading")
    R_WC[:, 0] = x
    R_WC[0, 1], R_WC[1, 1] = -x[1] / norm, x[0] / norm
    R_WC[:, 2] = cross(x, R_WC[:, 1])
    return R_WC
