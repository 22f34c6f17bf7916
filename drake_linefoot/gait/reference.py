"""The reference of the MPC: pendulum for the CoM, inverse kinematics for the legs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.gait.horizon import GaitHorizon
from drake_linefoot.gait.pendulum import follow_dcm
from drake_linefoot.gait.swing import YAW, LineMotion, line_turn
from drake_linefoot.math import so3
from drake_linefoot.mpc.parameters import ECD, MpcParameters
from drake_linefoot.robot.dynamics import centroidal_matrix, locked_inertia
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.leg_kinematics import LegPair
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

    def every_second(self, first: int) -> BodyMotion:
        """Return the motion at every second time from number `first` on."""
        rows = slice(first, None, 2)
        return BodyMotion(self.r[rows], self.v[rows], self.R[rows], self.Omega[rows])


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


def planned_feet(horizon: GaitHorizon, times: Array) -> LineMotion:
    """Return the planned motion of both contact lines at `times` [s] (n,), shapes (2, n, 5)."""
    left, right = (horizon.schedule.foot_motion(side, times) for side in (0, 1))
    return LineMotion(
        np.array([left.position, right.position]),
        np.array([left.velocity, right.velocity]),
        np.array([left.acceleration, right.acceleration]),
    )


class JointReference:
    """Joint angles and rates that go with a planned motion of torso and feet."""

    def __init__(self, humanoid: Humanoid) -> None:
        """Read the legs from the model."""
        self._humanoid = humanoid
        self._legs = LegPair(humanoid)

    def configurations(
        self, body: BodyMotion, feet: LineMotion, measured: Measured
    ) -> tuple[Array, Array, float]:
        """Return configurations and velocities at n times.

        The torso is put where the CoM, fixed in the torso as it is now, is on its
        reference; arms keep their angles; each leg reaches its planned contact line.

        Args:
            body: CoM and torso.
            feet: contact lines, shape (2, n, 5).
            measured: present state.

        Returns:
            (q, v, reach_error): shapes (n, nq), (n, nv) and the largest residual of the
            inverse kinematics [m, rad].
        """
        h, n = self._humanoid, len(body.r)
        offset = measured.R_WB.T @ (measured.r - measured.q[4:7])  # of the CoM, in B
        p_BG_W = body.R @ offset
        w_WB = (body.R @ body.Omega[..., None])[..., 0]
        p_WB = body.r - p_BG_W
        v_WB = body.v - so3.cross_rows(w_WB, p_BG_W)
        q = np.tile(measured.q, (n, 1))
        v = np.zeros((n, h.nv))
        yaw = np.arctan2(body.R[:, 1, 0], body.R[:, 0, 0])
        q[:, :4] = 0.0
        q[:, 0], q[:, 3] = np.cos(yaw / 2), np.sin(yaw / 2)
        q[:, 4:7] = p_WB
        v[:, :3], v[:, 3:6] = w_WB, v_WB
        d_W, w_line, _ = line_turn(feet.position, feet.velocity, feet.acceleration)
        p = feet.position[..., :3] - p_WB
        v_rel = feet.velocity[..., :3] - v_WB - so3.cross_rows(w_WB, p)
        guess = np.repeat(measured.q[h.leg_q][:, None], n, axis=1)
        angles, residual = self._legs.inverse(_into(body.R, p), _into(body.R, d_W), guess)
        rates = self._legs.rates(angles, _into(body.R, v_rel), _into(body.R, w_line - w_WB))
        for side in (0, 1):
            q[:, h.leg_q[side]] = angles[side]
            v[:, h.leg_v[side]] = rates[side]
        return q, v, float(residual.max())


def _into(R: Array, a: Array) -> Array:
    """Return vectors of W in the frames `R`, shape (..., n, 3)."""
    return (np.swapaxes(R, -1, -2) @ a[..., None])[..., 0]


def momentum_matrices(humanoid: Humanoid, context: Context, q: Array) -> Array:
    """Return the centroidal momentum matrix at each configuration, shape (n, 6, nv)."""
    plant = humanoid.plant
    base, r = np.empty((len(q), 6, humanoid.nv)), np.empty((len(q), 3))
    for k, qk in enumerate(q):
        plant.SetPositions(context, qk)
        base[k] = plant.CalcMassMatrix(context)[:6]
        r[k] = plant.CalcCenterOfMassPositionInWorld(context)
    return centroidal_matrix(base, r - q[:, 4:7])


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
        times = self.knots(horizon)
        middle = 0.5 * (times[1:] + times[:-1])
        both = np.empty(2 * p.knots + 1)
        both[::2], both[1::2] = times, middle
        body = body_motion(horizon, measured.r, both)
        at_knots, at_middle = body.every_second(0), body.every_second(1)
        feet = planned_feet(horizon, middle)
        planned = self.planned_legs if p.model == ECD else self.locked_legs
        I_B, L, reach = planned(at_middle, feet, measured)
        contact = horizon.schedule.contacts(middle)
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
            p_WC=np.swapaxes(feet.position[..., :3], 0, 1),
            R_WC=so3.rot_z(feet.position[..., YAW].T),
            reach_error=reach,
            footholds=horizon.footholds,
        )

    def knots(self, horizon: GaitHorizon) -> Array:
        """Return the knots of the MPC [s], shape (K + 1,): no foot switches between two."""
        p = self._parameters
        return horizon.schedule.knots(horizon.time, p.knots, p.knot_step)

    def planned_legs(
        self, body: BodyMotion, feet: LineMotion, measured: Measured
    ) -> tuple[Array, Array, float]:
        """Return inertia and angular momentum with legs that go where the feet are planned.

        Args:
            body: CoM and torso in K intervals.
            feet: contact lines there.
            measured: present state.

        Returns:
            (I_B, L, reach_error): shapes (K, 3, 3) and (K, 3), and the largest residual of
            the inverse kinematics.
        """
        q, v, reach = self._joints.configurations(body, feet, measured)
        A = momentum_matrices(self._humanoid, self._context, q)
        return locked_inertia(A, body.R), (A[:, :3] @ v[..., None])[..., 0], reach

    def locked_legs(
        self, body: BodyMotion, feet: LineMotion, measured: Measured
    ) -> tuple[Array, Array, float]:
        """Return the same for a single rigid body: the robot as it is now; see `planned_legs`."""
        A = momentum_matrices(self._humanoid, self._context, measured.q[None])
        I_B = np.tile(locked_inertia(A[0], measured.R_WB), (len(body.r), 1, 1))
        return I_B, (body.R @ I_B @ body.Omega[..., None])[..., 0], 0.0


def _between(L: Array) -> Array:
    """Return values at the knots from values in the middle of the intervals."""
    return np.vstack([L[:1], 0.5 * (L[1:] + L[:-1]), L[-1:]])
