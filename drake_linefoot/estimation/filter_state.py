"""What the filter remembers, as a record with named places, and what it knows of noise."""

from typing import Annotated, NamedTuple

import numpy as np

from drake_linefoot.axes import ENDS_OF_FEET, XYZ
from drake_linefoot.layout import Part, record_of
from drake_linefoot.parts import in_world, whole
from drake_linefoot.types import Array

POINTS = 4  # left heel, left toe, right heel, right toe
TURN, VELOCITY, PLACE, CONTACT = 0, 3, 6, 9  # where parts of the error begin
GYRO_BIAS, ACCELEROMETER_BIAS = CONTACT + 3 * POINTS, CONTACT + 3 * POINTS + 3
ERRORS = ACCELEROMETER_BIAS + 3


class Filter:
    """What the filter remembers, for compiled code to write."""

    time: Annotated[float, Part("since it has begun; negative before", "s")]
    R: Annotated[Array, in_world("R_WB", "-", XYZ, XYZ)]
    v: Annotated[Array, in_world("v_WB", "m/s", XYZ)]
    p: Annotated[Array, in_world("p_WB", "m", XYZ)]
    d: Annotated[Array, in_world("contact points", "m", ENDS_OF_FEET, XYZ)]
    gyro_bias: Annotated[Array, Part("of the IMU", "rad/s", XYZ, frame="B")]
    accelerometer_bias: Annotated[Array, Part("likewise", "m/s^2", XYZ, frame="B")]
    P: Annotated[Array, Part("covariance of the error", "-", ERRORS, ERRORS)]
    w: Annotated[Array, in_world("angular velocity", "rad/s", XYZ)]
    active: Annotated[Array, whole("1 for a point that holds", ENDS_OF_FEET)]
    since: Annotated[Array, Part("how long it has held", "s", ENDS_OF_FEET)]
    missed: Annotated[Array, Part("how long it was refused", "s", ENDS_OF_FEET)]
    load: Annotated[Array, Part("mean normal force, see `Noise.change`", "N", ENDS_OF_FEET)]
    innovation: Annotated[Array, Part("of the last tick; NaN: none", "m", ENDS_OF_FEET, XYZ)]
    nis: Annotated[Array, Part("squared Mahalanobis distance of it", "-", ENDS_OF_FEET)]
    refused: Annotated[float, whole("innovations outside the gate so far")]
    slips: Annotated[float, whole("points that had to hold anew so far")]
    alone: Annotated[float, Part("since a contact has agreed", "s")]
    unrest: Annotated[
        Array, Part("means at rest: rate, how far force and load are off", "rad/s, -", 3)
    ]


FILTER = record_of(Filter)
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
        change: time over which loads are averaged [s].
        delay: of the loads [s].
        dissipation: of the ground [s/m].
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
    change: float
    delay: float
    dissipation: float
    full: float
    touch: float
    release: float
    gate: float
    patience: float


def new_filter() -> Array:
    """Return the vector of a filter that has not begun."""
    vector = np.zeros(_DOUBLES)
    filter_of(vector).time = -1.0
    return vector


def filter_of(vector: Array) -> Filter:
    """Return the filter that a vector is, without a copy."""
    s: Filter = np.frombuffer(vector, FILTER)[0]
    return s
