"""Parameters of the sensors on board and of the state estimator."""

from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Le

from drake_linefoot.fields import NotNegative, Number, Positive, ScaledDefault, Unit
from drake_linefoot.parameters import Parameters


@dataclass
class OnboardParameters(Parameters):
    """The sensors on board: an IMU in the base frame B, encoders, motor currents.

    Defaults of the IMU: Analog Devices ADIS16470, data sheet rev. C, table 1. Its in-run bias
    stability, 8 deg/h and 13 ug, counts as a walk over 100 s. Its offsets at power-on are chosen
    here: what a calibration before the run leaves. Encoders: 14 bits on the rotor of a gear of 6.
    """

    gyro_noise: Annotated[NotNegative, Unit("rad/s/Hz^0.5")] = 1.4e-4
    """Noise density: 0.008 deg/s/Hz^0.5."""
    gyro_walk: Annotated[NotNegative, Unit("rad/s/s^0.5")] = 3.9e-6
    """Random walk of the bias."""
    gyro_offset: Annotated[NotNegative, Unit("rad/s")] = 3.5e-3
    """Standard deviation of the bias at the beginning: 0.2 deg/s."""
    gyro_range: Annotated[Positive, Unit("rad/s")] = 34.9
    """2000 deg/s."""
    accelerometer_noise: Annotated[NotNegative, Unit("m/s^2/Hz^0.5")] = 9.8e-4
    """Noise density: 100 ug/Hz^0.5."""
    accelerometer_walk: Annotated[NotNegative, Unit("m/s^2/s^0.5")] = 1.3e-5
    """Random walk of the bias."""
    accelerometer_offset: Annotated[NotNegative, Unit("m/s^2")] = 0.02
    """Standard deviation of the bias at the beginning: 2 mg."""
    accelerometer_range: Annotated[Positive, Unit("m/s^2")] = 392.0
    """40 g."""
    imu_rate: Annotated[Positive, Unit("1/s")] = 1000.0
    """Samples of the IMU; at most one a tick."""
    imu_delay: Annotated[Number, Ge(0), Le(0.02), Unit("s")] = 0.0
    """Whole ticks, between a sample and its use."""
    encoder_resolution: Annotated[NotNegative, Unit("rad")] = 6.4e-5
    """2 pi / (2^14 6)."""
    torque_noise: Annotated[NotNegative, Unit("N m")] = ScaledDefault(0.2)
    """Standard deviation of the torque that follows from a motor's current."""


@dataclass
class StateEstimatorParameters(Parameters):
    """How the state is estimated of what the sensors on board say."""

    rest: Annotated[Positive, Unit("s")] = 0.5
    """Time at the beginning in which the robot rests; the level is found in it."""
    slip: Annotated[NotNegative, Unit("m/s^0.5")] = ScaledDefault(7.0e-5)
    """Random walk of a contact point under a large force; twice that under `full_force`."""
    point_noise: Annotated[NotNegative, Unit("m")] = ScaledDefault(5.0e-5)
    """Of a contact point beside what encoders say: compliance, the round edge of the foot."""
    stiffness: Annotated[Positive, Unit("N/m")] = ScaledDefault(2.5e5)
    """Of a heel or toe on its ground; they sink in under their load."""
    settle: Annotated[NotNegative, Unit("s")] = ScaledDefault(0.02)
    """After a touch, in which a point has not come to rest."""
    load_time: Annotated[Positive, Unit("s")] = ScaledDefault(0.01)
    """Over which it is seen how fast loads change: what bears nothing soon is about to slip, and a
    fifth of what a point sinks by in it is not known."""
    load_delay: Annotated[NotNegative, Unit("s")] = 0.004
    """By which estimated loads are late: the filter (21), of 0.8 a millisecond."""
    dissipation: Annotated[NotNegative, Unit("s/m")] = ScaledDefault(12.0)
    """Of the ground (Hunt and Crossley): it bears so much more the faster it is pressed in."""
    full_force: Annotated[Positive, Unit("N")] = ScaledDefault(30.0)
    """Normal force of a contact point with which it counts as held; with less it may slip more."""
    touch_force: Annotated[Positive, Unit("N")] = ScaledDefault(15.0)
    """Normal force above which a heel or toe begins to hold."""
    release_force: Annotated[NotNegative, Unit("N")] = ScaledDefault(8.0)
    """Normal force below which it holds no more."""
    gate: Annotated[Positive, Unit("-")] = 7.81
    """Of the squared Mahalanobis distance of a point: chi-squared of 3, 95 %. A point that rests
    is far inside, as `point_noise` is that of errors that last, taken as white."""
    patience: Annotated[Positive, Unit("s")] = 0.01
    """A point that is refused for so long has slipped, and holds anew where it is."""
    lost: Annotated[Positive, Unit("s")] = 0.3
    """Without any contact that agrees, the estimate is lost."""
    rate_bandwidth: Annotated[Positive, Unit("rad/s")] = 1000.0
    """Of the filter that makes joint rates of encoders."""
