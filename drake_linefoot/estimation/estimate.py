"""One tick of the estimator: from what sensors and contacts say to the state of the robot.

Encoders say where heels and toes are, and how fast joints turn. A sole has its heel and its toe in
the middle of its width: encoders err alike at all its corners, so that four of them would count one
error twice as often, and what they would tell beside, the roll, gravity tells.
"""

import math
from typing import NamedTuple

import numpy as np

from drake_linefoot.axes import TAU_X, TAU_Y
from drake_linefoot.constants import GRAVITY, STANDARD_GRAVITY
from drake_linefoot.estimation.filter_state import CONTACT, PLACE, POINTS, VELOCITY, Filter, Noise
from drake_linefoot.estimation.invariant_filter import exponential, tick
from drake_linefoot.math.compiled import compiled, inlined
from drake_linefoot.math.linear import all_finite, dot
from drake_linefoot.math.rotation import log, skew
from drake_linefoot.robot.leg_kinematics import forward
from drake_linefoot.robot.legs import Legs
from drake_linefoot.types import Array, Indices

FINE, NOT_AT_REST, NOT_FINITE, ALONE, LYING = range(5)  # what becomes of an estimate
REST = (0.5, 0.3, 0.5)  # mean angular velocity [rad/s], and how far specific force and load are off
# [-], above which the robot did not rest at the beginning
TIPS = 0.95  # [-] of half the width of a sole: with its pressure so far aside it may tip
LARGEST_TILT = 1.0  # [rad] of a robot that stands


class Constants(NamedTuple):
    """What does not change from tick to tick.

    Attributes:
        legs: as chains.
        noise: of sensors and contacts.
        leg_joints: which actuators the joints of both legs are, shape (2, n_leg).
        actuated_q, actuated_v: of each actuator the index in q and v, shape (na,).
        half_length: of a contact [m].
        half_width: likewise, 0 of a line [m].
        weight: of the robot [N].
        period: of a tick [s].
        bandwidth: of the filter of the joint rates [rad/s].
        rest: how long the robot rests at the beginning [s].
        lost: longest time without a contact that agrees [s].
        delay: of the IMU [s].
    """

    legs: Legs
    noise: Noise
    leg_joints: Indices
    actuated_q: Indices
    actuated_v: Indices
    half_length: float
    half_width: float
    weight: float
    period: float
    bandwidth: float
    rest: float
    lost: float
    delay: float


@compiled
def contact_points(legs: Legs, angles: Array, half_length: float) -> tuple[Array, Array]:
    """Return heels and toes in the base frame, left before right, heel before toe.

    Args:
        legs: both.
        angles: of the leg joints [rad], shape (2, n_leg).
        half_length: of a contact [m].

    Returns:
        Positions p_BC [m], shape (4, 3), and their Jacobians by the angles of the own leg,
        shape (4, 3, n_leg).
    """
    p, R, J = forward(legs, angles.reshape(2, 1, -1))
    points, jacobians = np.empty((POINTS, 3)), np.empty((POINTS, 3, angles.shape[1]))
    for k in range(POINTS):
        side = k // 2
        out = (half_length if k % 2 else -half_length) * R[side, 0, :, 0]
        points[k] = p[side, 0] + out
        jacobians[k] = J[side, 0, :3] - skew(out) @ J[side, 0, 3:]
    return points, jacobians


@inlined
def point_loads(wrench: Array, contact: Array, half_length: float, half_width: float) -> Array:
    """Return the normal force of each heel and toe, 0 where the foot is in the air [N], (4,).

    The middle of the edges of a sole that may tip about its side, as all its load is there, does
    not rest, and counts as in the air.

    Args:
        wrench: of the feet [N, N m], shape (2, nw).
        contact: whether each foot stands, 0 or 1, shape (2,).
        half_length: of a contact [m].
        half_width: likewise, 0 of a line [m].
    """
    load = np.zeros(POINTS)
    for side in range(2):
        tilt = wrench[side, TAU_Y] / half_length
        if half_width > 0.0 and abs(wrench[side, TAU_X]) > TIPS * half_width * wrench[side, 2]:
            continue
        load[2 * side] = 0.5 * contact[side] * (wrench[side, 2] + tilt)
        load[2 * side + 1] = 0.5 * contact[side] * (wrench[side, 2] - tilt)
    return load


@inlined
def track(joints: Array, reading: Array, h: float, bandwidth: float) -> None:
    """Take in encoders: a critically damped filter of first order in the rate (fading memory).

    Args:
        joints: reading, filtered angle and rate of each joint [rad, rad/s], shape (3, na); written.
        reading: [rad], shape (na,).
        h: length of the tick [s].
        bandwidth: [rad/s].
    """
    theta = math.exp(-h * bandwidth)
    ahead = joints[1] + h * joints[2]
    joints[0] = reading
    joints[1] = ahead + (1.0 - theta * theta) * (reading - ahead)
    joints[2] += (1.0 - theta) ** 2 / h * (reading - ahead)


@inlined
def leg_points(encoders: Array, c: Constants) -> tuple[Array, Array]:
    """Return `contact_points` of the readings of all encoders [rad], shape (na,)."""
    angles = encoders[c.leg_joints.ravel()].reshape(c.leg_joints.shape)  # np.take compiles slowly
    return contact_points(c.legs, angles, c.half_length)


@compiled
def estimate(
    s: Filter,
    joints: Array,
    imu: Array,
    encoders: tuple[Array, Array],
    feet: tuple[Array, Array],
    c: Constants,
) -> tuple[Array, int]:
    """Carry filter and joints over a tick.

    Args:
        s: of a filter; written.
        joints: see `track`, shape (3, na); written.
        imu: angular velocity and specific force in B, shape (6,).
        encoders: when the IMU took its sample and now [rad], shapes (na,).
        feet: wrench of each foot [N, N m] and whether it stands, shapes (2, nw) and (2,), when
            the IMU took its sample.
        c: constants.

    Returns:
        See `robot_state`; and `FINE`, or what has become of the estimate.
    """
    load = point_loads(feet[0], feet[1], c.half_length, c.half_width)
    tick(s, imu, leg_points(encoders[0], c), load, c.period, c.noise)
    track(joints, encoders[1], c.period, c.bandwidth)
    borne = (feet[1] * feet[0][:, 2]).sum()
    return robot_state(s, joints, imu, c), outcome(s, imu, borne, c)


@inlined
def outcome(s: Filter, imu: Array, borne: float, c: Constants) -> int:
    """Return `FINE`, or what has become of the estimate.

    Args:
        s: of a filter; its means over the rest at the beginning are written.
        imu: angular velocity and specific force in B, shape (6,).
        borne: normal force on all feet [N].
        c: constants.
    """
    if s.time <= c.rest:
        share = c.period / c.rest
        s.unrest[0] += share * math.sqrt(dot(imu[:3], imu[:3]))
        s.unrest[1] += share * abs(math.sqrt(dot(imu[3:], imu[3:])) / STANDARD_GRAVITY - 1.0)
        s.unrest[2] += share * abs(1.0 - borne / c.weight)
        if s.time > c.rest - c.period:
            for i in range(3):
                if s.unrest[i] > REST[i]:
                    return NOT_AT_REST
    if not all_finite(s.P[:].ravel()):
        return NOT_FINITE
    if s.alone > c.lost:
        return ALONE
    return LYING if s.R[2, 2] < math.cos(LARGEST_TILT) else FINE


@compiled
def robot_state(s: Filter, joints: Array, imu: Array, c: Constants) -> Array:
    """Return the estimated state [q, v] in Drake's order, shape (2 na + 13,).

    The base is carried on over the delay of the IMU, as if its last sample held until now.

    Args:
        s: of a filter.
        joints: see `track`, shape (3, na).
        imu: angular velocity and specific force in B, shape (6,).
        c: constants.
    """
    na = joints.shape[1]
    x = np.empty(2 * na + 13)
    v, R = x[7 + na :], s.R[:].copy()
    x[4:7], v[:3], v[3:6] = s.p[:], s.w[:], s.v[:]
    if c.delay > 0.0:
        turn = exponential(0.5 * c.delay * (imu[:3] - s.gyro_bias[:]))[0]
        a = R @ turn @ (imu[3:] - s.accelerometer_bias[:]) + GRAVITY
        R = R @ turn @ turn
        v[:3] = R @ (imu[:3] - s.gyro_bias[:])
        v[3:6] += c.delay * a
        x[4:7] += c.delay * (s.v[:] + 0.5 * c.delay * a)
    x[:4] = quaternion(R)
    for i in range(na):
        x[c.actuated_q[i]], v[c.actuated_v[i]] = joints[0, i], joints[2, i]
    return x


@inlined
def quaternion(R: Array) -> Array:
    """Return a rotation as a quaternion w, x, y, z, shape (4,)."""
    phi, q = log(R), np.empty(4)
    angle = math.sqrt(dot(phi, phi))
    q[0] = math.cos(0.5 * angle)
    q[1:] = (math.sin(0.5 * angle) / angle if angle > 0.0 else 0.5) * phi
    return q


@compiled
def deviations(s: Filter) -> Array:
    """Return standard deviations of rotation, velocity and place in W, shape (9,).

    The error xi of velocity and place is taken about the origin of W: what they are off by
    has the turn about themselves less.
    """
    P = s.P[:CONTACT, :CONTACT].copy()
    E = np.eye(CONTACT)
    E[VELOCITY:PLACE, :3], E[PLACE:, :3] = -skew(s.v[:]), -skew(s.p[:])
    local = E @ P @ E.T.copy()
    return np.sqrt(np.maximum(np.diag(local), 0.0))
