"""The state estimator as a LeafSystem, between the sensors on board and the controller."""

import math

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues
from scipy.spatial.transform import Rotation

from drake_linefoot.constants import STANDARD_GRAVITY
from drake_linefoot.errors import EstimateError
from drake_linefoot.estimation.estimate import (
    ALONE,
    FINE,
    LARGEST_TILT,
    LYING,
    NOT_AT_REST,
    NOT_FINITE,
    Constants,
    deviations,
    estimate,
    leg_points,
    robot_state,
)
from drake_linefoot.estimation.filter_state import (
    ACCELEROMETER_BIAS,
    ERRORS,
    GYRO_BIAS,
    PLACE,
    TURN,
    VELOCITY,
    Filter,
    Noise,
    filter_of,
    new_filter,
)
from drake_linefoot.estimation.invariant_filter import begin
from drake_linefoot.estimation.parameters import OnboardParameters, StateEstimatorParameters
from drake_linefoot.layout import Layout
from drake_linefoot.leaf_system import read_finite, read_signal, weak
from drake_linefoot.math.compiled import as_python
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.legs import read_legs
from drake_linefoot.robot.scaling import scaled
from drake_linefoot.signals import ContactEstimate, StateEstimate
from drake_linefoot.tunable_block import TunableBlock
from drake_linefoot.types import Array

TILT, SPEED = 0.02, 0.05  # [rad], [m/s] standard deviations at the beginning
SURE = 1e-6  # [rad, m] of heading and place, which are 0 where it begins


class StateEstimator(TunableBlock[StateEstimatorParameters, Constants]):
    """Estimates the state from IMU, encoders and contact, by an invariant Kalman filter.

    .. pydrake_system::

        name: StateEstimator
        input_ports:
        - imu
        - encoders
        - contact
        output_ports:
        - state
        - covariance
        - report

    `StateEstimatorParameters` are numeric parameters.
    Updates every `period`; the discrete state is a `FILTER` record, three numbers of each
    joint, see `track`, and the estimate. The update sees the sensors after the plant's step and
    the contact of the tick before. Heading and place count from where it begins, at rest. With
    an IMU that is late the filter is as late: encoders and contact wait for it in the last
    discrete state, oldest first, and the estimate is carried on to now.

    Raises SignalError for an input that is not finite, EstimateError when the estimate is lost or
    the robot did not rest.
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
        p, self._onboard, na = scaled(parameters, humanoid), onboard, humanoid.na
        self.declare_parameters(p, lambda p: constants_of(p, onboard, humanoid, period))
        self._imu = self.DeclareVectorInputPort("imu", 6)
        self._encoders = self.DeclareVectorInputPort("encoders", na)
        self._of_contact = Layout(ContactEstimate, humanoid.sizes)
        self._contact = self.signal_input("contact", self._of_contact)
        self.DeclareDiscreteState(new_filter())
        self.DeclareDiscreteState(np.zeros(3 * na))
        x = self.DeclareDiscreteState(humanoid.x_nominal)
        late = round(onboard.imu_delay / period)
        self._waiting = np.full((late, na + 2 * humanoid.contact.size + 2), np.nan)  # nothing yet
        self.DeclareDiscreteState(self._waiting.ravel())
        self.DeclareStateOutputPort("state", x)
        when = {self.xd_ticket()}
        self.DeclareVectorOutputPort(
            "covariance", ERRORS**2, weak(self, self._calc_covariance), prerequisites_of_calc=when
        )
        self._report = Layout(StateEstimate, {})
        self.signal_output("report", self._report, self._calc_report, when)
        self.DeclareInitializationDiscreteUpdateEvent(weak(self, self._initialize))
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, weak(self, self._update))

    def _initialize(self, context: Context, discrete: DiscreteValues) -> None:
        """Begin at rest, level by the accelerometer."""
        vector = context.get_discrete_state(0).value().copy()
        s, c = filter_of(vector), self.constants_in(context)
        if s.time >= 0.0:
            return  # it goes on from a context that was saved
        imu = read_finite(self, self._imu, context)
        encoders = read_finite(self, self._encoders, context)
        if np.linalg.norm(imu[3:]) < 0.5 * STANDARD_GRAVITY:
            raise EstimateError("nothing carries the robot at the beginning")
        begin(s, imu, as_python(leg_points)(encoders, c)[0], initial_sigma(self._onboard))
        joints = np.array([encoders, encoders, np.zeros(len(encoders))])
        x = robot_state(s, joints, imu, c)
        for i, values in enumerate((vector, joints.ravel(), x)):
            discrete.set_value(i, values)

    def go_on_from(self, context: Context, x: Array) -> None:
        """Begin in the midst of a motion, with a state that is known; its biases are not.

        Args:
            context: of this system.
            x: the state in Drake's order, shape (nq + nv,).
        """
        vector, c = new_filter(), self.constants_in(context)
        s, na = filter_of(vector), len(c.actuated_q)
        v = x[7 + na :]
        s.R = Rotation.from_quat(x[:4], scalar_first=True).as_matrix()
        s.p, s.w, s.v, s.time = x[4:7], v[:3], v[3:6], c.rest
        variances = initial_sigma(self._onboard) ** 2
        variances[:GYRO_BIAS] = SURE**2
        s.P = np.diag(variances)  # a point is placed when it holds
        context.SetDiscreteState(3, self._waiting.ravel())
        angles = x[c.actuated_q]
        joints = np.array([angles, angles, v[c.actuated_v]])
        for i, values in enumerate((vector, joints.ravel(), x)):
            context.SetDiscreteState(i, values)

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        imu = read_finite(self, self._imu, context)
        encoders = read_finite(self, self._encoders, context)
        contact = read_signal(self, self._contact, context, self._of_contact)
        vector = context.get_discrete_state(0).value().copy()
        joints = context.get_discrete_state(1).value().copy().reshape(3, -1)
        s, c = filter_of(vector), self.constants_in(context)
        feet = contact.wrench, contact.contact
        then = encoders
        if len(self._waiting):
            waiting = context.get_discrete_state(3).value().reshape(self._waiting.shape)
            newest = np.concatenate([encoders, feet[0].ravel(), feet[1]])
            discrete.set_value(3, np.vstack([waiting[1:], newest]).ravel())
            if np.isnan(waiting[0, 0]):
                return  # the first sample is on its way
            then, wrench, flags = np.split(waiting[0], [len(encoders), -2])
            feet = wrench.reshape(feet[0].shape), flags
        x, outcome = estimate(s, joints, imu, (then, encoders), feet, c)
        if outcome != FINE:
            raise EstimateError(_reason(outcome, s, c))
        for i, values in enumerate((vector, joints.ravel(), x)):
            discrete.set_value(i, values)

    def _calc_covariance(self, context: Context, output: BasicVector) -> None:
        s = filter_of(context.get_discrete_state(0).value().copy())
        output.SetFromVector(s.P.ravel())

    def _calc_report(self, context: Context, output: BasicVector) -> None:
        vector, x = (context.get_discrete_state(i).value().copy() for i in (0, 2))
        output.SetFromVector(self._report.vector(_report(vector, x)))


def constants_of(
    p: StateEstimatorParameters, onboard: OnboardParameters, humanoid: Humanoid, period: float
) -> Constants:
    """Return the constants of a robot's filter, with parameters in its size."""
    return Constants(
        legs=read_legs(humanoid),
        noise=noise_of(onboard, p),
        leg_joints=humanoid.leg_joints,
        actuated_q=humanoid.actuated_q,
        actuated_v=humanoid.actuated_v,
        half_length=humanoid.half_length,
        half_width=humanoid.half_width,
        weight=humanoid.mass * STANDARD_GRAVITY,
        period=float(period),
        bandwidth=float(p.rate_bandwidth),
        rest=float(p.rest),
        lost=float(p.lost),
        delay=float(onboard.imu_delay),
    )


def _reason(outcome: int, s: Filter, c: Constants) -> str:
    """Return in words why there is no estimate any more."""
    if outcome == NOT_AT_REST:
        w, f, load = (float(mean) for mean in s.unrest)
        return (
            f"the robot did not rest in the first {c.rest:g} s: mean angular velocity "
            f"{w:.2f} rad/s, specific force off g by {f:.2f} g, what feet carry off the weight "
            f"by {load:.0%}"
        )
    return {
        NOT_FINITE: "its covariance is not finite",
        ALONE: f"no contact has agreed with the IMU for {c.lost:g} s",
        LYING: f"the robot lies: tilted beyond {LARGEST_TILT:g} rad",
    }[outcome]


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
        stiffness=float(p.stiffness),
        settle=float(p.settle),
        change=float(p.load_time),
        delay=float(p.load_delay),
        dissipation=float(p.dissipation),
        full=float(p.full_force),
        touch=float(p.touch_force),
        release=float(p.release_force),
        gate=float(p.gate),
        patience=float(p.patience),
    )


def initial_sigma(onboard: OnboardParameters) -> Array:
    """Return the standard deviations of the error at the beginning, shape (ERRORS,)."""
    deviations = np.full(ERRORS, SURE)
    deviations[TURN : TURN + 2] = TILT
    deviations[VELOCITY:PLACE] = SPEED
    deviations[GYRO_BIAS:ACCELEROMETER_BIAS] = onboard.gyro_offset
    deviations[ACCELEROMETER_BIAS:] = onboard.accelerometer_offset
    return deviations


def _report(vector: Array, x: Array) -> StateEstimate:
    s, v = filter_of(vector), len(x) // 2 + 1
    measured = np.isfinite(s.nis)
    return StateEstimate(
        pose=x[:7],
        velocity=x[v : v + 6],
        sigma=deviations(s),
        biases=np.concatenate([s.gyro_bias, s.accelerometer_bias]),
        innovation=np.where(measured[:, None], s.innovation, 0.0),
        nis=np.where(measured, s.nis, 0.0),
        measured=measured.astype(float),
        stands=s.active,
        refused=float(s.refused),
        slips=float(s.slips),
    )
