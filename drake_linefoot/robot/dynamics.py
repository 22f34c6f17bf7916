"""Rigid-body and centroidal quantities of one state, computed once and shared."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.tree import JacobianWrtVariable

from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.kernels import state_terms

if TYPE_CHECKING:
    from pydrake.systems.framework import Context

Array = NDArray[np.float64]

_BY_VELOCITY = JacobianWrtVariable.kV

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


@dataclass(eq=False)  # frozen, each field would cost a call when one is made
class RobotDynamics:
    """What the controller needs to know of one state; not to be changed.

    The equation of motion is ``M vdot + Cv = tau_g + S' tau + sum J_i' w_i``.

    Attributes:
        q: positions, shape (nq,).
        v: velocities, shape (nv,).
        M: mass matrix with reflected inertias, shape (nv, nv).
        Cv: Coriolis and centrifugal forces, shape (nv,).
        tau_g: generalized gravity forces, shape (nv,).
        R_WB: torso orientation, shape (3, 3).
        p_WG: centre of mass [m], shape (3,).
        base: bias of the rate of (angular, linear) momentum, and velocity of the centre of
            mass, shape (9,).
        A: centroidal momentum matrix, angular about G over linear, shape (6, nv).
        J: line-contact Jacobians (51) of both feet, shape (2, 5, nv).
        R_WC: contact frames of both feet, shape (2, 3, 3).
        lines: p_WC, v_WC, w_WF and Jdot_v of each contact line, see `FootMotion`, (2, 14).
    """

    q: Array
    v: Array
    M: Array
    Cv: Array
    tau_g: Array
    R_WB: Array
    p_WG: Array
    base: Array
    A: Array
    J: Array
    R_WC: Array
    lines: Array

    @property
    def p_WB(self) -> Array:
        """Torso origin [m], shape (3,)."""
        return self.q[4:7]

    @property
    def v_WG(self) -> Array:
        """Velocity of the centre of mass [m/s], shape (3,)."""
        return self.base[6:]

    @property
    def Adot_v(self) -> Array:
        """Rate of (angular, linear) momentum at vdot = 0, shape (6,)."""
        return self.base[:6]

    @property
    def p_WC(self) -> Array:
        """Middle of each contact line [m], shape (2, 3)."""
        return self.lines[:, :3]

    @property
    def L_G(self) -> Array:
        """Angular momentum about the CoM [kg m^2/s], shape (3,)."""
        return self.A[:3] @ self.v

    @cached_property
    def feet(self) -> tuple[FootMotion, FootMotion]:
        """Left and right, made when asked for: views of `lines`, `J` and `R_WC`."""
        return self._foot(0), self._foot(1)

    def _foot(self, side: int) -> FootMotion:
        line = self.lines[side]
        return FootMotion(
            p_WC=line[:3],
            R_WC=self.R_WC[side],
            v_WC=line[3:6],
            w_WF=line[6:9],
            J=self.J[side],
            Jdot_v=line[9:],
        )


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
    plant, W = humanoid.plant, humanoid.world
    plant.SetPositionsAndVelocities(context, x)
    q, v = x[: humanoid.nq], x[humanoid.nq :]
    nv = len(v)
    M = plant.CalcMassMatrix(context).T  # symmetric; in the order of rows
    Cv = plant.CalcBiasTerm(context)
    p_WG = plant.CalcCenterOfMassPositionInWorld(context)
    X_WF, J_V, bias = [], [], []
    for side, frame in enumerate(humanoid.foot_frames):
        X_WF.append(frame.CalcPoseInWorld(context).GetAsMatrix34())
        args = context, _BY_VELOCITY, frame, humanoid.p_FC[side], W, W
        J_V.append(plant.CalcJacobianSpatialVelocity(*args))
        bias.append(plant.CalcBiasSpatialAcceleration(*args).get_coeffs())
    A, tau_g, base, R_WB = np.empty((6, nv)), np.empty(nv), np.empty(9), np.empty((3, 3))
    lines, R_WC, J = np.empty((2, 14)), np.empty((2, 3, 3)), np.empty((2, 5, nv))
    given = M, Cv, q, v, GRAVITY, p_WG, tuple(X_WF), humanoid.p_FC, tuple(J_V), tuple(bias)
    state_terms(*given, A, tau_g, base, R_WB, lines, R_WC, J)
    return RobotDynamics(q, v, M, Cv, tau_g, R_WB, p_WG, base, A, J, R_WC, lines)


class SharedDynamics:
    """`robot_dynamics` for blocks that ask for the same state one after the other.

    The estimator and the gait see a state at the end of a tick, controller and recorder at
    the beginning of the next: it is computed once.

    Attributes:
        scratch: context of the robot's plant, for whoever computes something of it at once;
            with one for all its memory stays near the processor.
    """

    def __init__(self, humanoid: Humanoid) -> None:
        """Allocate the scratch context."""
        self._humanoid = humanoid
        self.scratch = humanoid.plant.CreateDefaultContext()
        self._key = b""
        self._value: RobotDynamics | None = None

    def knows(self, x: Array) -> bool:
        """Return whether the last state was this one, which was finite then."""
        return x.tobytes() == self._key

    def __call__(self, x: Array) -> RobotDynamics:
        """Return the quantities of a state [q, v], shape (nq + nv,); not to be changed."""
        key = x.tobytes()
        if self._value is None or key != self._key:
            self._value = robot_dynamics(self._humanoid, self.scratch, x.copy())
            self._key = key
        return self._value
