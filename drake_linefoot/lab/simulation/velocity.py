"""The velocity of a walk, as it is seen over a while."""

import numpy as np

from drake_linefoot.lab.simulation.recorder import Recorder
from drake_linefoot.math.rotation import roll_pitch_yaw
from drake_linefoot.types import Array

WINDOW = 0.5  # [s] over which what is reported is measured
ENOUGH = 502  # samples that cover it, at 1 ms


def recent_samples(recorder: Recorder) -> slice:
    """Return which of the last `ENOUGH` samples are of the last half second."""
    times = recorder.samples("time", ENOUGH)
    return slice(int(np.searchsorted(times, times[-1:].sum() - WINDOW)), None)


def recent_velocity(recorder: Recorder) -> Array:
    """Return the CoM's velocity over the last half second in the heading frame, shape (3,).

    Forward and left [m/s], turn rate [rad/s]; zero before there are two samples.
    """
    recent = recent_samples(recorder)
    times, q, com = (recorder.samples(name, ENOUGH)[recent] for name in ("time", "q", "com"))
    if len(times) < 2:
        return np.zeros(3)
    return mean_velocity(times, com, np.unwrap(roll_pitch_yaw(q[:, :4])[:, 2]))


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
