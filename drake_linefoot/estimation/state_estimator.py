"""The state estimator as a LeafSystem, between the sensors on board and the controller."""

import math

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import BasicVector, Context, DiscreteValues

from drake_linefoot.constants import STANDARD_GRAVITY
from drake_linefoot.errors import EstimateError
from drake_linefoot.estimation.invariant_filter import (
    ACCELEROMETER_BIAS,
    CONTACT,
    ERRORS,
    GYRO_BIAS,
    PLACE,
    TURN,
    VELOCITY,
    Noise,
    begin,
    filter_record,
    new_filter,
    tick,
)
from drake_linefoot.estimation.kinematics import contact_points, point_loads, track
from drake_linefoot.estimation.parameters import OnboardParameters, StateEstimatorParameters
from drake_linefoot.leaf_system import Block, read_finite, read_signal, weak
from drake_linefoot.math.rotation import log, skew
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.legs import read_legs
from drake_linefoot.robot.size import sized
from drake_linefoot.signals import ContactEstimate, StateEstimate
from drake_linefoot.types import Array

BIAS_SIGMAS = 1.0  # [-] offsets that the filter begins with, in standard deviations of the sensors
TILT, SPEED = 0.02, 0.05  # [rad], [m/s] standard deviations at the beginning
SURE = 1e-6  # [rad, m] of heading and place, which are 0 where it begins
REST = np.array([0.5, 0.15, 0.5])  # mean angular velocity [rad/s], specific force beyond
# g and missing load [-], above which the robot did not rest at the beginning
LARGEST_TILT = 1.0  # [rad] of a robot that stands


class StateEstimator(Block):
    """Estimates the state from IMU, encoders and contact, by an invariant Kalman filter.

    | port | type | shape | unit |
    |---|---|---|---|
    | imu | vector | 6 | rad/s, m/s^2: angular velocity, specific force in B |
    | encoders | vector | na | rad |
    | contact | ContactEstimate | - | N, N m |
    | state | vector | nq + nv | Drake's order, for the controller |
    | covariance | vector | 27 x 27 | of the error, see `invariant_filter` |
    | report | StateEstimate | - | innovations, NIS, biases |

    Updates every `period`; the discrete state is a `FILTER` record and three numbers of each
    joint, see `track`. The update sees the sensors after the plant's step and the contact of the
    tick before. Heading and place count from where it begins, at rest. Raises SignalError for an
    input that is not finite, EstimateError when the estimate is lost or the robot did not rest.
    """

    def __init__(
        self,
        humanoid: Humanoid,
        onboard: OnboardParameters,
        parameters: StateEstimatorParameters,
        period: float = 0.001,
    ) -> None:
        """Declare ports, state and events.

        Args:
            humanoid: the robot.
            onboard: what the sensors are like.
            parameters: of the filter.
            period: between two updates, and of the plant's steps [s].
        """
        super().__init__()
        self.set_name("state_estimator")
        self._h, self._humanoid, self._legs = float(period), humanoid, read_legs(humanoid)
        self._p, self._onboard = sized(parameters, humanoid), onboard
        self._noise = noise_of(self._onboard, self._p)
        names = humanoid.description.actuated_joints
        legs = [foot.leg_joints for foot in humanoid.description.feet]
        self._leg_joints = np.array([[names.index(name) for name in leg] for leg in legs])
        self._imu = self.DeclareVectorInputPort("imu", 6)
        self._encoders = self.DeclareVectorInputPort("encoders", humanoid.na)
        self._contact = self.DeclareAbstractInputPort("contact", AbstractValue.Make(object()))
        self.DeclareDiscreteState(new_filter())
        self.DeclareDiscreteState(np.zeros(3 * humanoid.na))
        size, when = humanoid.nq + humanoid.nv, {self.xd_ticket()}
        self.DeclareVectorOutputPort(
            "state", size, weak(self, self._calc_state), prerequisites_of_calc=when
        )
        self.DeclareVectorOutputPort(
            "covariance", ERRORS**2, weak(self, self._calc_covariance), prerequisites_of_calc=when
        )
        self.DeclareAbstractOutputPort(
            "report",
            lambda: AbstractValue.Make(_report(new_filter())),
            weak(self, self._calc_report),
            prerequisites_of_calc=when,
        )
        self.DeclareInitializationDiscreteUpdateEvent(weak(self, self._initialize))
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, weak(self, self._update))

    def _points(self, encoders: Array) -> tuple[Array, Array]:
        return contact_points(self._legs, encoders[self._leg_joints], self._humanoid.half_length)

    def _initialize(self, context: Context, discrete: DiscreteValues) -> None:
        """Begin at rest, level by the accelerometer."""
        vector = context.get_discrete_state(0).value().copy()
        if filter_record(vector).time >= 0.0:
            return  # it goes on from a context that was saved
        imu = read_finite(self, self._imu, context)
        encoders = read_finite(self, self._encoders, context)
        if np.linalg.norm(imu[3:]) < 0.5 * STANDARD_GRAVITY:
            raise EstimateError("nothing carries the robot at the beginning")
        deviations = beginning(self._onboard)
        begin(filter_record(vector), imu, self._points(encoders)[0], deviations)
        discrete.set_value(0, vector)
        joints = np.concatenate([encoders, encoders, np.zeros(self._humanoid.na)])
        discrete.set_value(1, joints)

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        imu = read_finite(self, self._imu, context)
        encoders = read_finite(self, self._encoders, context)
        estimate = read_signal(self, self._contact, context, ContactEstimate)
        vector = context.get_discrete_state(0).value().copy()
        joints = context.get_discrete_state(1).value().copy().reshape(3, -1)
        flags = np.array(estimate.contact, dtype=float)
        load = point_loads(estimate.wrench, flags, self._humanoid.half_length)
        s = filter_record(vector)
        tick(s, imu, self._points(encoders), load, self._h, self._noise)
        track(joints, encoders, self._h, self._p.rate_bandwidth)
        self._check(s, imu, load)
        discrete.set_value(0, vector)
        discrete.set_value(1, joints.ravel())

    def _check(self, s: np.record, imu: Array, load: Array) -> None:
        """Say so when the estimate is lost, or cannot have begun well.

        Raises:
            EstimateError: it is.
        """
        if s.time <= self._p.rest:
            missing = 1.0 - load.sum() / (self._humanoid.mass * STANDARD_GRAVITY)
            beyond = np.linalg.norm(imu[3:]) / STANDARD_GRAVITY - 1.0
            unrest = np.array([np.linalg.norm(imu[:3]), beyond, missing])
            s.unrest += self._h / self._p.rest * unrest
            if s.time > self._p.rest - self._h and (np.abs(s.unrest) > REST).any():
                w, f, m = s.unrest
                raise EstimateError(
                    f"the robot did not rest in the first {self._p.rest:g} s: mean angular "
                    f"velocity {w:.2f} rad/s, specific force {1.0 + f:.2f} g, feet carry "
                    f"{1.0 - m:.0%} of the weight"
                )
        if not np.isfinite(s.P).all():
            raise EstimateError("its covariance is not finite")
        if s.alone > self._p.lost:
            raise EstimateError(f"no contact has agreed with the IMU for {self._p.lost:g} s")
        if s.R[2, 2] < math.cos(LARGEST_TILT):
            raise EstimateError(f"the robot lies: tilted beyond {LARGEST_TILT:g} rad")

    def _calc_state(self, context: Context, output: BasicVector) -> None:
        s = filter_record(context.get_discrete_state(0).value().copy())
        joints = context.get_discrete_state(1).value().reshape(3, -1)
        h = self._humanoid
        x = np.zeros(h.nq + h.nv)
        x[:4], x[4:7] = _quaternion(s.R), s.p
        x[h.actuated_q] = joints[0]
        x[h.nq : h.nq + 3], x[h.nq + 3 : h.nq + 6] = s.w, s.v
        x[h.nq + h.actuated_v] = joints[2]
        if s.time < 0.0:
            x[:] = h.x_nominal
        output.SetFromVector(x)

    def _calc_covariance(self, context: Context, output: BasicVector) -> None:
        s = filter_record(context.get_discrete_state(0).value().copy())
        output.SetFromVector(s.P.ravel())

    def _calc_report(self, context: Context, output: AbstractValue) -> None:
        output.set_value(_report(context.get_discrete_state(0).value().copy()))


def noise_of(onboard: OnboardParameters, p: StateEstimatorParameters) -> Noise:
    """Return what a filter has to know of noise; the robot's size is in `p` already."""
    return Noise(
        gyro=float(onboard.gyro_noise),
        accelerometer=float(onboard.accelerometer_noise),
        gyro_walk=float(onboard.gyro_walk),
        accelerometer_walk=float(onboard.accelerometer_walk),
        encoder=float(onboard.encoder_resolution) / math.sqrt(12.0),
        slip=float(p.slip),
        point=float(p.point_noise),
        full=float(p.full_force),
        touch=float(p.touch_force),
        release=float(p.release_force),
        gate=float(p.gate),
        patience=float(p.patience),
    )


def beginning(onboard: OnboardParameters) -> Array:
    """Return the standard deviations of the error at the beginning, shape (ERRORS,)."""
    deviations = np.full(ERRORS, SURE)
    deviations[TURN : TURN + 2] = TILT
    deviations[VELOCITY:PLACE] = SPEED
    deviations[GYRO_BIAS:ACCELEROMETER_BIAS] = BIAS_SIGMAS * onboard.gyro_offset
    deviations[ACCELEROMETER_BIAS:] = BIAS_SIGMAS * onboard.accelerometer_offset
    return deviations


def _report(vector: Array) -> StateEstimate:
    s = filter_record(vector)
    # The error in W about the base: xi of a turn is taken at the origin of W.
    at = np.eye(CONTACT, ERRORS)
    for first, lever in ((VELOCITY, s.v), (PLACE, s.p)):
        at[first : first + 3, TURN : TURN + 3] = -skew(lever)
    local = at @ s.P @ at.T
    return StateEstimate(
        pose=np.concatenate([_quaternion(s.R), s.p]),
        velocity=np.concatenate([s.w, s.v]),
        sigma=np.sqrt(np.maximum(np.diagonal(local), 0.0)),
        biases=np.concatenate([s.gyro_bias, s.accelerometer_bias]),
        innovation=s.innovation.copy(),
        nis=s.nis.copy(),
        holds=s.active.copy(),
        refused=float(s.refused),
        slips=float(s.slips),
    )


def _quaternion(R: Array) -> Array:
    """Return a rotation as a quaternion w, x, y, z."""
    phi = log(np.ascontiguousarray(R))
    half = 0.5 * float(np.linalg.norm(phi))
    return np.concatenate([[math.cos(half)], 0.5 * np.sinc(half / math.pi) * phi])
