"""Where heels and toes are, and how fast joints turn, as encoders say."""

import math

import numpy as np

from drake_linefoot.contact.wrench_cone import WRENCH_SIZE
from drake_linefoot.estimation.filter_state import POINTS
from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.rotation import skew
from drake_linefoot.robot.leg_kinematics import forward
from drake_linefoot.robot.legs import Legs
from drake_linefoot.types import Array


@compiled
def contact_points(legs: Legs, angles: Array, half_length: float) -> tuple[Array, Array]:
    """Return heels and toes in the base frame, left before right, heel before toe.

    Args:
        legs: both.
        angles: of the leg joints [rad], shape (2, 5).
        half_length: of a contact line [m].

    Returns:
        Positions p_BC [m], shape (4, 3), and their Jacobians by the angles of the own leg,
        shape (4, 3, 5).
    """
    p, R, J = forward(legs, angles.reshape(2, 1, -1))
    points, jacobians = np.empty((POINTS, 3)), np.empty((POINTS, 3, angles.shape[1]))
    for k in range(POINTS):
        side = k // 2
        out = (half_length if k % 2 else -half_length) * R[side, 0, :, 0]
        points[k] = p[side, 0] + out
        jacobians[k] = J[side, 0, :3] - skew(out) @ J[side, 0, 3:]
    return points, jacobians


@compiled
def point_loads(wrench: Array, contact: Array, half_length: float) -> Array:
    """Return the normal force of each heel and toe, 0 where the foot is in the air [N], (4,).

    Args:
        wrench: of the feet [N, N m], shape (2, 5).
        contact: whether each foot stands, 0 or 1, shape (2,).
        half_length: of a contact line [m].
    """
    load = np.zeros(POINTS)
    for side in range(2):
        tilt = wrench[side, WRENCH_SIZE - 2] / half_length
        load[2 * side] = 0.5 * contact[side] * (wrench[side, 2] + tilt)
        load[2 * side + 1] = 0.5 * contact[side] * (wrench[side, 2] - tilt)
    return load


@compiled
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
