"""The reference of the MPC: pendulum for the CoM, inverse kinematics for the legs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.gait.horizon import GaitHorizon
from drake_linefoot.gait.pendulum import follow_dcm
from drake_linefoot.gait.swing import line_turn
from drake_linefoot.math import so3
from drake_linefoot.mpc.parameters import ECD, MpcParameters
from drake_linefoot.robot.dynamics import centroidal_matrix, locked_inertia
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.leg_kinematics import LegChain
from drake_linefoot.signals import Reference

if TYPE_CHECKING:
    from pydrake.systems.framework import Context

Array = NDArray[np.float64]


@dataclass(frozen=True)
class BodyMotion:
    """Desired CoM and torso at n times.

    Attributes:
        r, v: CoM [m, m/s], shape (n, 3).
        R: torso orientation, shape (n, 3, 3).
        Omega: torso angular velocity in B [rad/s], shape (n, 3).
    """

    r: Array
    v: Array
    R: Array
    Omega: Array


@dataclass(frozen=True)
class Measured:
    """What the reference starts from.

    Attributes:
        q: positions, shape (nq,).
        r: CoM [m], shape (3,).
        R_WB: torso orientation, shape (3, 3).
    """

    q: Array
    r: Array
    R_WB: Array


def body_motion(horizon: GaitHorizon, com: Array, times: Array) -> BodyMotion:
    """Return r_d, v_d from the pendulum and R_d, Omega_d from the command.

    Args:
        horizon: the gait.
        com: present CoM [m], shape (3,).
        times: increasing, the first not before the horizon's start [s], shape (n,).
    """
    n = len(times)
    r, v = np.empty((n, 3)), np.zeros((n, 3))
    r[:, :2], v[:, :2] = follow_dcm(com[:2], horizon.dcm, times, horizon.omega)
    r[:, 2] = horizon.com_height
    R = so3.rot_z(horizon.yaw + horizon.turn_rate * (times - horizon.time))
    Omega = np.tile([0.0, 0.0, horizon.turn_rate], (n, 1))
    return BodyMotion(r, v, R, Omega)


class JointReference:
    """Joint angles and rates that go with a planned motion of torso and feet."""

    def __init__(self, humanoid: Humanoid) -> None:
        """Read the leg chains from the model."""
        self._humanoid = humanoid
        self._chains = (LegChain(humanoid, 0), LegChain(humanoid, 1))

    def configurations(
        self, body: BodyMotion, horizon: GaitHorizon, measured: Measured, times: Array
    ) -> tuple[Array, Array, float]:
        """Return configurations and velocities at `times`.

        The torso is put where the CoM, fixed in the torso as it is now, is on its
        reference; arms keep their angles; each leg reaches its planned contact line.

        Args:
            body: CoM and torso at `times`.
            horizon: the gait, for the feet.
            measured: present state.
            times: [s], shape (n,).

        Returns:
            (q, v, reach_error): shapes (n, nq), (n, nv) and the largest residual of the
            inverse kinematics [m, rad].
        """
        h, n = self._humanoid, len(times)
        offset = measured.R_WB.T @ (measured.r - measured.q[4:7])  # of the CoM, in B
        p_BG_W = body.R @ offset
        w_WB = (body.R @ body.Omega[..., None])[..., 0]
        p_WB = body.r - p_BG_W
        v_WB = body.v - np.cross(w_WB, p_BG_W)
        q = np.tile(measured.q, (n, 1))
        v = np.zeros((n, h.nv))
        yaw = np.arctan2(body.R[:, 1, 0], body.R[:, 0, 0])
        q[:, :4] = np.stack([np.cos(yaw / 2), 0 * yaw, 0 * yaw, np.sin(yaw / 2)], axis=1)
        q[:, 4:7] = p_WB
        v[:, :3], v[:, 3:6] = w_WB, v_WB
        worst = 0.0
        for side, chain in enumerate(self._chains):
            foot = horizon.schedule.foot_motion(side, times)
            d_W, w_line, _ = line_turn(foot.position, foot.velocity, foot.acceleration)
            p = foot.position[:, :3] - p_WB
            p_BC = _into(body.R, p)
            guess = np.tile(measured.q[h.leg_q[side]], (n, 1))
            angles, residual = chain.inverse(p_BC, _into(body.R, d_W), guess)
            v_rel = _into(body.R, foot.velocity[:, :3] - v_WB - np.cross(w_WB, p))
            rates = chain.rates(angles, v_rel, _into(body.R, w_line - w_WB))
            q[:, h.leg_q[side]] = angles
            v[:, h.leg_v[side]] = rates
            worst = max(worst, float(residual.max()))
        return q, v, worst


def _into(R: Array, a: Array) -> Array:
    """Return vectors of W in the frames `R`, shape (n, 3)."""
    return np.einsum("nji,nj->ni", R, a)


def momentum_matrices(humanoid: Humanoid, context: Context, q: Array) -> Array:
    """Return the centroidal momentum matrix at each configuration, shape (n, 6, nv)."""
    plant = humanoid.plant
    A = np.empty((len(q), 6, humanoid.nv))
    for k, qk in enumerate(q):
        plant.SetPositions(context, qk)
        M = plant.CalcMassMatrix(context)
        r = plant.CalcCenterOfMassPositionInWorld(context) - qk[4:7]
        A[k] = centroidal_matrix(M, r)
    return A


class ReferenceGenerator:
    """Turns the gait into the reference of the MPC."""

    def __init__(self, humanoid: Humanoid, parameters: MpcParameters) -> None:
        """Keep robot and parameters; allocate the scratch context."""
        self._humanoid = humanoid
        self._parameters = parameters
        self._joints = JointReference(humanoid)
        self._context = humanoid.plant.CreateDefaultContext()

    def generate(self, horizon: GaitHorizon, measured: Measured) -> Reference:
        """Return the reference over the horizon.

        With the model "ecd" inertia and angular momentum follow the planned legs; with
        "srbm" the inertia is frozen at its present value and the joints count as locked.

        Args:
            horizon: the gait.
            measured: present state.
        """
        p = self._parameters
        times = horizon.schedule.knots(horizon.time, p.knots, p.knot_step)
        middle = 0.5 * (times[1:] + times[:-1])
        at_knots = body_motion(horizon, measured.r, times)
        at_middle = body_motion(horizon, measured.r, middle)
        if p.model == ECD:
            q, v, reach = self._joints.configurations(at_middle, horizon, measured, middle)
            A = momentum_matrices(self._humanoid, self._context, q)
            I_B = locked_inertia(A, at_middle.R)
            L = (A[:, :3] @ v[..., None])[..., 0]
        else:
            A = momentum_matrices(self._humanoid, self._context, measured.q[None])
            I_B = np.tile(locked_inertia(A[0], measured.R_WB), (p.knots, 1, 1))
            L = (at_middle.R @ I_B @ at_middle.Omega[..., None])[..., 0]
            reach = 0.0
        contact = horizon.schedule.contacts(middle)
        feet = np.stack(
            [horizon.schedule.foot_motion(side, middle).position for side in (0, 1)], axis=1
        )
        return Reference(
            times=times,
            r=at_knots.r,
            v=at_knots.v,
            R=at_knots.R,
            L=_between(L),
            r_mid=at_middle.r,
            v_mid=at_middle.v,
            R_mid=at_middle.R,
            Omega_mid=at_middle.Omega,
            L_mid=L,
            I_B=I_B,
            contact=contact,
            p_WC=feet[..., :3],
            R_WC=so3.rot_z(feet[..., 4]),
            reach_error=reach,
            footholds=horizon.footholds,
        )


def _between(L: Array) -> Array:
    """Return values at the knots from values in the middle of the intervals."""
    return np.vstack([L[:1], 0.5 * (L[1:] + L[:-1]), L[-1:]])
