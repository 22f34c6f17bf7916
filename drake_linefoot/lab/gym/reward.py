"""The reward of a step, a plain function of what happened in it."""

from typing import NamedTuple

import numpy as np

from drake_linefoot.types import Array

SPEED_SCALE = 0.25  # [m/s, rad/s] of an error that costs most of the reward
TILT_WEIGHT, TORQUE_WEIGHT = 0.5, 0.1  # [1/rad], [-]


class Moment(NamedTuple):
    """What a reward is made of."""

    goal: Array  # forward, left [m/s] and turn rate [rad/s] that are wanted, shape (3,)
    velocity: Array  # as measured over the last half second, in the heading frame, shape (3,)
    tilt: float  # larger of roll and pitch of the torso [rad]
    torque: Array  # of the motors over their limits [-], shape (na,)
    fell: bool  # whether the robot has fallen


def tracking(moment: Moment) -> float:
    """Return 1 for a robot that is upright and walks as wanted without effort; 0 after a fall."""
    if moment.fell:
        return 0.0
    error = (moment.velocity - moment.goal) / SPEED_SCALE
    effort = float(np.mean(np.square(moment.torque)))
    tracked = float(np.exp(-np.sum(np.square(error))))
    return tracked - TILT_WEIGHT * moment.tilt - TORQUE_WEIGHT * effort
