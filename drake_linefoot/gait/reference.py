"""The reference of the MPC: pendulum for the CoM, inverse kinematics for the legs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.gait.horizon import GaitHorizon
from drake_linefoot.gait.pendulum import follow_dcm
from drake_linefoot.gait.reference_kernels import contact_frames, headings, lines_in_torso
from drake_linefoot.gait.swing import LineMotion
from drake_linefoot.mpc.parameters import ECD, MpcParameters
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.leg_inertia import LegInertia
from drake_linefoot.robot.leg_kinematics import LegPair
from drake_linefoot.signals import Reference

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
        parts = (self.r, self.v, self.R, self.Omega)
        return BodyMotion(*(np.ascontiguousarray(part[rows]) for part in parts))


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
    slope, ground = horizon.slope, horizon.ground
    r[:, 2] = ground[2] + (r[:, :2] - ground[:2]).dot(slope) + horizon.com_height
    v[:, 2] = v[:, :2].dot(slope)
    R = headings(horizon.yaw, horizon.turn_rate, times - horizon.time)
    Omega = np.zeros((n, 3))
    Omega[:, 2] = horizon.turn_rate
    return BodyMotion(r, v, R, Omega)


class JointReference:
    """Joint angles and rates that go with a planned motion of torso and feet.

    Attributes:
        legs: both.
    """

    def __init__(self, humanoid: Humanoid) -> None:
        """Read the legs from the model."""
        self.legs = LegPair(humanoid)
        self._leg_q = humanoid.leg_q

    def follow(
        self, body: BodyMotion, feet: LineMotion, measured: Measured
    ) -> tuple[Array, Array, float]:
        """Return joint angles and rates of the legs at K times.

        The torso is put where the CoM, fixed in the torso as it is now, is on its
        reference; each leg reaches its planned contact line.

        Args:
            body: CoM and torso.
            feet: contact lines, shape (2, K, 5).
            measured: present state.

        Returns:
            (angles, rates, reach_error): [rad] and [rad/s], shapes (2, K, 5), and the largest
            residual of the inverse kinematics [m, rad].
        """
        offset = measured.R_WB.T @ (measured.r - measured.q[4:7])  # of the CoM, in B
        p, d, v, w = lines_in_torso(
            body.r, body.v, body.R, body.Omega, offset, feet.position, feet.velocity
        )
        guess = np.repeat(measured.q[self._leg_q][:, None], len(body.r), axis=1)
        angles, residual = self.legs.inverse(p, d, guess)
        return angles, self.legs.rates(angles, v, w), float(residual.max())


class ReferenceGenerator:
    """Turns the gait into the reference of the MPC."""

    def __init__(self, humanoid: Humanoid, parameters: MpcParameters) -> None:
        """Keep parameters, and what is to know of the robot."""
        self._parameters = parameters
        self._joints = JointReference(humanoid)
        self._inertia = LegInertia(humanoid, self._joints.legs)
        self._leg_q = humanoid.leg_q

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
        feet = horizon.schedule.feet_motion(middle)
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
            p_WC=np.ascontiguousarray(np.swapaxes(feet.position[..., :3], 0, 1)),
            R_WC=contact_frames(feet.position),
            slope=horizon.slope,
            reach_error=reach,
            footholds=horizon.footholds,
        )

    def knots(self, horizon: GaitHorizon) -> Array:
        """Return the knots of the MPC [s], shape (K + 1,): no foot switches between two.

        The first is when the plan begins to be used.
        """
        p = self._parameters
        return horizon.schedule.knots(horizon.time + p.lead, p.knots, p.knot_step)

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
        angles, rates, reach = self._joints.follow(body, feet, measured)
        I_B, L_B = self._inertia(measured.q, angles, rates, body.Omega)
        return I_B, (body.R @ L_B[..., None])[..., 0], reach

    def locked_legs(
        self, body: BodyMotion, feet: LineMotion, measured: Measured
    ) -> tuple[Array, Array, float]:
        """Return the same for a single rigid body: the robot as it is now; see `planned_legs`."""
        angles = measured.q[self._leg_q][:, None]
        now, _ = self._inertia(measured.q, angles, np.zeros((2, 1, 5)), np.zeros((1, 3)))
        I_B = np.tile(now, (len(body.r), 1, 1))
        return I_B, (body.R @ I_B @ body.Omega[..., None])[..., 0], 0.0


def _between(L: Array) -> Array:
    """Return values at the knots from values in the middle of the intervals."""
    return np.vstack([L[:1], 0.5 * (L[1:] + L[:-1]), L[-1:]])
