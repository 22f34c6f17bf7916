"""What the gait asks for, whatever the model: CoM and torso, and contact lines.

The CoM follows the pendulum, the torso the command.
"""

from typing import NamedTuple

import numpy as np

from drake_linefoot.axes import WRENCH
from drake_linefoot.gait.pendulum import follow_dcm, rise_at
from drake_linefoot.gait.schedule import contacts, feet_motion, slopes_at
from drake_linefoot.gait.state import PITCH, YAW
from drake_linefoot.gait.swing import LineMotion, line_axes
from drake_linefoot.math.compiled import compiled, inlined
from drake_linefoot.math.rotation import axes_on_plane
from drake_linefoot.math.vectors import (
    column,
    crossed,
    plus,
    times,
    turned,
    turned_back,
    vector,
    write,
    write_column,
)
from drake_linefoot.robot.leg_inertia import Masses
from drake_linefoot.robot.legs import Legs
from drake_linefoot.signals import (
    GaitHorizon,
    Reference,
    RobotDynamics,
    open_horizon,
    open_reference,
)
from drake_linefoot.types import Array, Indices


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


class Robot(NamedTuple):
    """What the reference needs to know of a robot.

    Attributes:
        legs: both.
        masses: of its bodies; those of the torso are written.
        leg_q: index in q of each joint of the legs, shape (2, j).
        mass: [kg].
        determinant: of a leg's Jacobian in the nominal posture, see `reaching`.
        arm_v: index in v of each joint of the arms, shape (m,).
        turns: which way each swings, see `arm_turns`, shape (m,).
        arm_swing: see `GaitHorizon` [rad/m].
        nv: number of velocities.
        nw: how many numbers the wrench of a foot has.
    """

    legs: Legs
    masses: Masses
    leg_q: Indices
    mass: float
    determinant: float
    arm_v: Indices
    turns: Array
    arm_swing: float
    nv: int
    nw: int


@inlined
def body_motion(horizon: GaitHorizon, com: Array, times: Array) -> BodyMotion:
    """Return r_d, v_d from the pendulum and R_d, Omega_d from the command.

    Args:
        horizon: the gait.
        com: present CoM [m], shape (3,).
        times: increasing, the first not before the horizon's start [s], shape (n,).
    """
    h, n, start = horizon, len(times), np.empty(2)
    r, v, Omega = np.empty((n, 3)), np.empty((n, 3)), np.zeros((n, 3))
    pitch, yaw = np.zeros(n), np.empty(n)
    for j in range(2):
        start[j] = com[j] + h.lean[j]
    pieces = int(h.pieces)
    xy, rate = follow_dcm(start, h.dcm[:pieces], times)
    rise = rise_at(h.dcm[:pieces], h.rise[:pieces], times)
    for i in range(n):
        r[i, 2], v[i, 2] = h.ground[2] + h.com_height + rise[0, i], rise[1, i]
        for j in range(2):
            r[i, j], v[i, j] = xy[i, j] - h.lean[j], rate[i, j]
            r[i, 2] += (r[i, j] - h.ground[j]) * h.slope[j]
            v[i, 2] += v[i, j] * h.slope[j]
        yaw[i], Omega[i, 2] = h.yaw + h.turn_rate * (times[i] - h.time), h.turn_rate
    return BodyMotion(r, v, line_axes(pitch, yaw), Omega)


@inlined
def line_plan(feet: LineMotion, slopes: Array, nw: int) -> LinePlan:
    """Return the planned contacts: of a line y is level, a sole lies flat on the ground.

    Args:
        feet: motion of both.
        slopes: of the ground under each, rise per metre along x and y of W, shape (K, 2, 2).
        nw: how many numbers the wrench of a foot has.
    """
    _, K, _ = feet.position.shape
    p, v, w = np.empty((2, K, 3)), np.empty((2, K, 3)), np.empty((2, K, 3))
    pitch, yaw = np.empty(2 * K), np.empty(2 * K)
    for side in range(2):
        for k in range(K):
            pitch[side * K + k] = feet.position[side, k, PITCH]
            yaw[side * K + k] = feet.position[side, k, YAW]
    R = line_axes(pitch, yaw).reshape((2, K, 3, 3))
    for side in range(2):
        for k in range(K):
            if nw == len(WRENCH):
                R[side, k] = axes_on_plane(R[side, k, :, 0].copy(), slopes[k, side])
            for i in range(3):
                p[side, k, i], v[side, k, i] = feet.position[side, k, i], feet.velocity[side, k, i]
                w[side, k, i] = feet.velocity[side, k, PITCH] * R[side, k, i, 1]
            w[side, k, 2] = feet.velocity[side, k, YAW]
    return LinePlan(p, R, v, w)


@inlined
def places_in_torso(body: BodyMotion, lines: LinePlan) -> tuple[Array, Array]:
    """Return middles from the CoM [m] and frames of contacts in B, (2, K, 3) and (2, K, 3, 3)."""
    places, frames = np.empty(lines.p.shape), np.empty(lines.R.shape)
    for side in range(2):
        for k in range(len(body.R)):
            arm = plus(vector(lines.p[side], k, 0), times(-1.0, vector(body.r, k, 0)))
            write(places[side], k, 0, turned_back(body.R, k, arm))
            for i in range(3):
                axis = turned_back(body.R, k, column(lines.R[side], k, i))
                write_column(frames[side], k, i, axis)
    return places, frames


@inlined
def rates_in_torso(body: BodyMotion, lines: LinePlan) -> tuple[Array, Array]:
    """Return how contact lines move in W, with the axes of B [m/s, rad/s], shape (2, K, 3)."""
    v, w = np.empty(lines.v.shape), np.empty(lines.v.shape)
    for side in range(2):
        for k in range(len(body.R)):
            write(v[side], k, 0, turned_back(body.R, k, vector(lines.v[side], k, 0)))
            write(w[side], k, 0, turned_back(body.R, k, vector(lines.w[side], k, 0)))
    return v, w


@inlined
def relative_rates(body: BodyMotion, lines: LinePlan) -> tuple[Array, Array]:
    """Return how contact lines move relative to the torso, in B [m/s, rad/s], shape (2, K, 3).

    The torso turns about the CoM.
    """
    v, w = rates_in_torso(body, lines)
    for side in range(2):
        for k in range(len(body.R)):
            Omega = vector(body.Omega, k, 0)
            arm = plus(vector(lines.p[side], k, 0), times(-1.0, vector(body.r, k, 0)))
            turning = crossed(Omega, turned_back(body.R, k, arm))
            own = turned_back(body.R, k, vector(body.v, k, 0))
            for i in range(3):
                v[side, k, i] -= own[i] + turning[i]
                w[side, k, i] -= Omega[i]
    return v, w


@compiled
def desired_motion(reference: Array, horizon: Array, knots: Array, com: Array, nw: int) -> LinePlan:
    """Write the motion that no model changes into a reference.

    Args:
        reference: `Reference`, as it travels; times, contact, and what CoM, torso and lines do are
            written.
        horizon: `GaitHorizon`, likewise.
        knots: [s], shape (K + 1,).
        com: present CoM [m], shape (3,).
        nw: how many numbers the wrench of a foot has.

    Returns:
        The contacts in the middles of the intervals.
    """
    K = len(knots) - 1
    ref, h = open_reference(reference, K), open_horizon(horizon, K)
    every, middle = np.empty(2 * K + 1), np.empty(K)
    for k in range(K + 1):
        every[2 * k] = ref.times[k] = knots[k]
        if k < K:
            every[2 * k + 1] = middle[k] = 0.5 * (knots[k + 1] + knots[k])
    standing, slopes = contacts(h, middle), slopes_at(h, middle)
    motion, lines = body_motion(h, com, every), line_plan(feet_motion(h, middle), slopes, nw)
    for k in range(K + 1):
        copy_body(motion, 2 * k, ref.r, ref.v, ref.R, k)
        if k < K:
            copy_body(motion, 2 * k + 1, ref.r_mid, ref.v_mid, ref.R_mid, k)
            write(ref.Omega_mid, k, 0, vector(motion.Omega, 2 * k + 1, 0))
            for side in range(2):
                ref.contact[k, side] = standing[k, side]
                ref.slope[k, side, 0] = slopes[k, side, 0]
                ref.slope[k, side, 1] = slopes[k, side, 1]
                for i in range(3):
                    ref.p_WC[k, side, i] = lines.p[side, k, i]
                    for j in range(3):
                        ref.R_WC[k, side, i, j] = lines.R[side, k, i, j]
    return lines


@inlined
def middles(ref: Reference) -> BodyMotion:
    """Return CoM and torso in the middles of the intervals."""
    return BodyMotion(ref.r_mid, ref.v_mid, ref.R_mid, ref.Omega_mid)


@compiled
def copy_body(motion: BodyMotion, i: int, r: Array, v: Array, R: Array, k: int) -> None:
    """Write CoM, its velocity and the torso at time `i` of a motion as those of time `k`."""
    write(r, k, 0, vector(motion.r, i, 0))
    write(v, k, 0, vector(motion.v, i, 0))
    for j in range(3):
        write_column(R, k, j, column(motion.R, i, j))


@inlined
def arm_momentum(ref: Reference, lines: LinePlan, now: RobotDynamics, robot: Robot) -> Array:
    """Return the angular momentum of arms that swing as planned, about the CoM.

    Args:
        ref: what the torso does.
        lines: planned in the middles of the intervals.
        now: of the present state: an arm has the momentum by its rate that it has there.
        robot: what is to know of it.

    Returns:
        In B [kg m^2/s], shape (K, 3).
    """
    K, of_rate, L = lines.p.shape[1], np.zeros(3), np.zeros((lines.p.shape[1], 3))
    for i in range(len(robot.turns)):
        for r in range(3):
            for j in range(3):
                of_rate[r] += robot.turns[i] * now.R_WB[j, r] * now.A[j, robot.arm_v[i]]
    for k in range(K):
        rate = 0.0
        for j in range(3):
            rate += ref.R_mid[k, j, 0] * (lines.v[1, k, j] - lines.v[0, k, j])
        for r in range(3):
            L[k, r] = robot.arm_swing * rate * of_rate[r]
    return L


@inlined
def write_momentum(ref: Reference, L_B: Array) -> None:
    """Write the angular momentum, in the middles and between them at the knots.

    Args:
        ref: views that are written.
        L_B: about the CoM in the middles, in B [kg m^2/s], shape (K, 3).
    """
    K = len(L_B)
    for k in range(K):
        write(ref.L_mid, k, 0, turned(ref.R_mid, k, vector(L_B, k, 0)))
    for k in range(K + 1):
        for i in range(3):
            ref.L[k, i] = 0.5 * (ref.L_mid[max(k - 1, 0), i] + ref.L_mid[min(k, K - 1), i])
