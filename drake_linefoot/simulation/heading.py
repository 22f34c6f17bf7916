"""Velocity as a walking robot means it: along and across its own heading."""

import numpy as np

from drake_linefoot.types import Array


def mean_velocity(time: Array, position: Array, yaw: Array) -> Array:
    """Return the mean velocity over a window in the heading frame, which follows the yaw.

    Each displacement from one sample to the next is turned into the heading half way, so a
    robot that walks a circle at 0.5 m/s has 0.5 m/s forward. What sways to and fro cancels
    when the window covers whole strides.

    Args:
        time: samples [s], shape (n,), n at least 2.
        position: of the CoM or of a body [m], shape (n, 2) or wider; x and y are used.
        yaw: of the torso without jumps [rad], shape (n,).

    Returns:
        v_x, v_y [m/s] and turn rate [rad/s], shape (3,).
    """
    step = np.diff(position[:, :2], axis=0)
    heading = 0.5 * (yaw[1:] + yaw[:-1])
    c, s = np.cos(heading), np.sin(heading)
    forward = np.sum(c * step[:, 0] + s * step[:, 1])
    left = np.sum(c * step[:, 1] - s * step[:, 0])
    return np.array([forward, left, yaw[-1] - yaw[0]]) / (time[-1] - time[0])
