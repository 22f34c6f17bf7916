"""What the filter remembers, as a record with named places, and what it knows of noise."""

from typing import NamedTuple

import numpy as np

from drake_linefoot.types import Array

POINTS = 4  # left heel, left toe, right heel, right toe
TURN, VELOCITY, PLACE, CONTACT = 0, 3, 6, 9  # where parts of the error begin
GYRO_BIAS, ACCELEROMETER_BIAS = CONTACT + 3 * POINTS, CONTACT + 3 * POINTS + 3
ERRORS = ACCELEROMETER_BIAS + 3

FILTER = np.dtype(
    (
        np.record,
        [
            ("time", "f8"),  # since it has begun [s]; negative before
            ("R", "f8", (3, 3)),  # R_WB
            ("v", "f8", 3),  # v_WB [m/s]
            ("p", "f8", 3),  # p_WB [m]
            ("d", "f8", (POINTS, 3)),  # contact points [m]
            ("gyro_bias", "f8", 3),  # [rad/s]
            ("accelerometer_bias", "f8", 3),  # [m/s^2]
            ("P", "f8", (ERRORS, ERRORS)),  # covariance of the error
            ("w", "f8", 3),  # angular velocity in W [rad/s]
            ("active", "f8", POINTS),  # 1 for a point that holds
            ("since", "f8", POINTS),  # how long it has held [s]
            ("missed", "f8", POINTS),  # how long it was refused [s]
            ("innovation", "f8", (POINTS, 3)),  # of the last tick [m]; NaN where none
            ("nis", "f8", POINTS),  # its squared Mahalanobis distance; NaN where none
            ("refused", "f8"),  # innovations outside the gate so far
            ("slips", "f8"),  # points that had to hold anew so far
            ("alone", "f8"),  # since a contact has agreed [s]
            ("unrest", "f8", 3),  # angular velocity, specific force beyond g, load: mean at rest
        ],
    )
)
_DOUBLES = FILTER.itemsize // 8


class Noise(NamedTuple):
    """What is known of sensors and contacts, in continuous time.

    Attributes:
        gyro, accelerometer: noise densities [rad/s/Hz^0.5], [m/s^2/Hz^0.5].
        gyro_walk, accelerometer_walk: of the biases [rad/s/s^0.5], [m/s^2/s^0.5].
        encoder: standard deviation of an angle [rad].
        slip: random walk of a point under full force [m/s^0.5].
        point: standard deviation of a point beside that of the encoders [m].
        stiffness: of a point on its ground [N/m].
        settle: how long a point that has touched is not at rest [s].
        full, touch, release: normal forces of a point [N], see `StateEstimatorParameters`.
        gate: largest squared Mahalanobis distance.
        patience: see there [s].
    """

    gyro: float
    accelerometer: float
    gyro_walk: float
    accelerometer_walk: float
    encoder: float
    slip: float
    point: float
    stiffness: float
    settle: float
    full: float
    touch: float
    release: float
    gate: float
    patience: float


def new_filter() -> Array:
    """Return the vector of a filter that has not begun."""
    vector = np.zeros(_DOUBLES)
    np.frombuffer(vector, FILTER)[0].time = -1.0
    return vector


def filter_record(vector: Array) -> np.record:
    """Return the filter that a vector is, without a copy."""
    return np.frombuffer(vector, FILTER)[0]
