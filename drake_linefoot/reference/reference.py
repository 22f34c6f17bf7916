"""The reference of the MPC: pendulum for the CoM, inverse kinematics for the legs."""

from typing import NamedTuple

import numpy as np

from drake_linefoot.centroidal import TIME_EPSILON
from drake_linefoot.gait.pendulum import follow_dcm
from drake_linefoot.gait.schedule import contacts, feet_motion, knots
from drake_linefoot.gait.state import PITCH, YAW
from drake_linefoot.gait.swing import LineMotion, line_axes
from drake_linefoot.math.rotation import crosses
from drake_linefoot.reference.contact_consistent import (
    angular_momentum,
    contact_maps,
    determinant,
    torso_rates,
)
from drake_linefoot.reference.parameters import CONTACT_CONSISTENT, ECD, ReferenceParameters
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.leg_inertia import LegInertia
from drake_linefoot.robot.leg_kinematics import inverse, rates
from drake_linefoot.robot.legs import read_legs
from drake_linefoot.signals import GaitHorizon, Reference, RobotDynamics
from drake_linefoot.types import Array

Inertias = tuple[Array, Array, Array, float]  # I_B, L, E, reach_error of `Reference`


class BodyMotion(NamedTuple):
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


def body_motion(horizon: GaitHorizon, com: Array, times: Array) -> BodyMotion:
    """Return r_d, v_d from the pendulum and R_d, Omega_d from the command.

    Args:
        horizon: the gait.
        com: present CoM [m], shape (3,).
        times: increasing, the first not before the horizon's start [s], shape (n,).
    """
    n = len(times)
    r, v, Omega = np.empty((n, 3)), np.zeros((n, 3)), np.zeros((n, 3))
    on_pendulum, pieces = com[:2] + horizon.lean, horizon.dcm[: int(horizon.pieces)]
    r[:, :2], v[:, :2] = follow_dcm(on_pendulum, pieces, times, horizon.omega)
    r[:, :2] -= horizon.lean
    slope, ground = horizon.slope, horizon.ground
    r[:, 2] = ground[2] + (r[:, :2] - ground[:2]).dot(slope) + horizon.com_height
    v[:, 2] = v[:, :2].dot(slope)
    R = line_axes(np.zeros(n), horizon.yaw + horizon.turn_rate * (times - horizon.time))
    Omega[:, 2] = horizon.turn_rate
    return BodyMotion(r, v, R, Omega)


class LinePlan(NamedTuple):
    """Planned contact lines at K times, left before right, in W.

    Attributes:
        p: middles [m], shape (2, K, 3).
        R: frames, shape (2, K, 3, 3).
        v: velocities of the middles [m/s], shape (2, K, 3).
        w: angular velocities [rad/s], shape (2, K, 3).
    """

    p: Array
    R: Array
    v: Array
    w: Array


def line_plan(feet: LineMotion) -> LinePlan:
    """Return contact lines in W, given their five coordinates, shape (2, K, 5)."""
    pitch, yaw = (feet.position[..., i].ravel() for i in (PITCH, YAW))
    R = line_axes(pitch, yaw).reshape(2, -1, 3, 3)
    w = feet.velocity[..., PITCH, None] * R[..., 1]
    w[..., 2] = feet.velocity[..., YAW]
    return LinePlan(feet.position[..., :3], R, feet.velocity[..., :3], w)


def places_in_torso(body: BodyMotion, lines: LinePlan) -> tuple[Array, Array]:
    """Return middles from the CoM [m] and directions of contact lines in B, shape (2, K, 3)."""
    R_BW = body.R.swapaxes(1, 2)
    return np.matvec(R_BW, lines.p - body.r), np.matvec(R_BW, lines.R[..., 0])


def rates_in_torso(body: BodyMotion, lines: LinePlan) -> tuple[Array, Array]:
    """Return how contact lines move in W, with the axes of B [m/s, rad/s], shape (2, K, 3)."""
    R_BW = body.R.swapaxes(1, 2)
    return np.matvec(R_BW, lines.v), np.matvec(R_BW, lines.w)


def relative_rates(body: BodyMotion, lines: LinePlan) -> tuple[Array, Array]:
    """Return how contact lines move relative to the torso, in B [m/s, rad/s], shape (2, K, 3).

    The torso turns about the CoM.
    """
    R_BW = body.R.swapaxes(1, 2)
    turning = crosses(body.Omega, np.matvec(R_BW, lines.p - body.r))
    v = np.matvec(R_BW, lines.v - body.v) - turning
    return v, np.matvec(R_BW, lines.w) - body.Omega


class ReferenceGenerator:
    """Turns the gait into the reference of the MPC."""

    def __init__(self, humanoid: Humanoid, parameters: ReferenceParameters) -> None:
        """Keep parameters, and what is to know of the robot."""
        self._parameters = parameters
        self._legs = read_legs(humanoid)
        self._inertia = LegInertia(humanoid, self._legs)
        self._leg_q, self._mass = humanoid.leg_q, humanoid.mass
        self._determinant = determinant(self._legs, humanoid.q_nominal[humanoid.leg_q])

    def generate(self, horizon: GaitHorizon, d: RobotDynamics) -> Reference:
        """Return the reference over the horizon.

        With the model "ecd" inertia and angular momentum follow the planned legs; with
        "contact_consistent" the torso's rate does, too, with feet that go as planned; with
        "srbm" and "srbm_momentum" the inertia is frozen at its present value and the joints
        count as locked.

        Args:
            horizon: the gait.
            d: quantities of the present state.
        """
        times = self.knots(horizon)
        middle = 0.5 * (times[1:] + times[:-1])
        at_knots, at_middle = (body_motion(horizon, d.p_WG, t) for t in (times, middle))
        lines = line_plan(feet_motion(horizon, middle))
        models = {CONTACT_CONSISTENT: self.moving_legs, ECD: self.planned_legs}
        legs = models.get(self._parameters.model, self.locked_legs)
        I_B, L, E, reach = legs(at_middle, lines, d)
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
            turns=float(self._parameters.model == CONTACT_CONSISTENT),
            E=E,
            contact=contacts(horizon, middle),
            p_WC=np.ascontiguousarray(lines.p.swapaxes(0, 1)),
            R_WC=np.ascontiguousarray(lines.R.swapaxes(0, 1)),
            slope=horizon.slope,
            friction=horizon.friction,
            external=horizon.external,
            reach_error=reach,
            coming=horizon.coming,
            footholds=horizon.footholds,
        )

    def knots(self, horizon: GaitHorizon) -> Array:
        """Return the knots of the MPC [s], shape (K + 1,): no foot switches between two.

        The first is when the plan begins to be used. With "contact_consistent" the first interval
        ends just after that use: how a swinging leg turns the torso changes that fast.
        """
        p = self._parameters
        begin = horizon.time + p.lead
        if p.model != CONTACT_CONSISTENT or p.knots == 1:
            return knots(horizon, begin, p.knots, p.knot_step)
        used = knots(horizon, begin, 1, min(p.period + 2.0 * TIME_EPSILON, p.knot_step))
        return np.append(used[:1], knots(horizon, used[1], p.knots - 1, p.knot_step))

    def joints(self, body: BodyMotion, lines: LinePlan, d: RobotDynamics) -> tuple[Array, float]:
        """Return joint angles of the legs that go with a planned motion.

        The torso is put where the CoM, fixed in the torso as it is now, is on its
        reference; each leg reaches its planned contact line.

        Args:
            body: CoM and torso at K times.
            lines: planned there.
            d: quantities of the present state.

        Returns:
            (angles, reach_error): [rad], shape (2, K, 5), and the largest residual of the inverse
            kinematics [m, rad].
        """
        offset = d.R_WB.T @ (d.p_WG - d.q[4:7])  # of the CoM, in B
        p, direction = places_in_torso(body, lines)
        guess = np.repeat(d.q[self._leg_q][:, None], len(body.r), axis=1)
        angles, residual = inverse(self._legs, p + offset, direction, guess, 8, 1e-6)
        return angles, float(residual.max())

    def planned_legs(self, body: BodyMotion, lines: LinePlan, d: RobotDynamics) -> Inertias:
        """Return inertia and angular momentum with legs that go where the feet are planned.

        Returns:
            (I_B, L, E, reach_error): shapes (K, 3, 3), (K, 3) and (K, 3, 6), and the largest
            residual of the inverse kinematics.
        """
        angles, reach = self.joints(body, lines, d)
        maps = self._inertia(d.q, angles)
        joint_rates = rates(self._legs, angles, *relative_rates(body, lines))
        L_B = maps.momentum(joint_rates, body.Omega)
        return maps.I_B, np.matvec(body.R, L_B), _locked(body), reach

    def moving_legs(self, body: BodyMotion, lines: LinePlan, d: RobotDynamics) -> Inertias:
        """Return the same with legs that let the torso turn over the feet; E of `torso_rates`."""
        angles, reach = self.joints(body, lines, d)
        maps = self._inertia(d.q, angles)
        v, w = rates_in_torso(body, lines)
        A, c = contact_maps(self._legs, angles, maps, v, w, self._mass, self._determinant)
        L_B = angular_momentum(A, c, body.Omega, self._mass * np.vecmat(body.v, body.R))
        return maps.I_B, np.matvec(body.R, L_B), torso_rates(A), reach

    def locked_legs(self, body: BodyMotion, lines: LinePlan, d: RobotDynamics) -> Inertias:
        """Return the same for a single rigid body: the robot as it is now; see `planned_legs`."""
        angles = d.q[self._leg_q][:, None]
        now = self._inertia(d.q, angles).I_B
        I_B = np.tile(now, (len(body.r), 1, 1))
        return I_B, np.matvec(body.R @ I_B, body.Omega), _locked(body), 0.0


def _locked(body: BodyMotion) -> Array:
    """Return E of a model in which the joints count as locked: there is none."""
    return np.zeros((len(body.r), 3, 6))


def _between(L: Array) -> Array:
    """Return values at the knots from values in the middle of the intervals."""
    return np.vstack([L[:1], 0.5 * (L[1:] + L[:-1]), L[-1:]])
