"""What the controller gets to know of the state: with noise, or as sensors on board say."""

import numpy as np
from numpy.typing import ArrayLike
from pydrake.common import RandomDistribution, RandomGenerator
from pydrake.systems.framework import BasicVector, Context, DiscreteValues
from pydrake.systems.primitives import RandomSource

from drake_linefoot.estimation.parameters import OnboardParameters
from drake_linefoot.lab.scenario.disturbances import SensorParameters
from drake_linefoot.leaf_system import Block, weak
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.types import Array

BASE_NOISE = 12  # random numbers for the base, after two for each joint
IMU_NOISE = 12  # random numbers of the IMU: of its readings, and of its biases; then the torques
_NOISE, _OFFSETS = 2, 4  # streams of random numbers, beside those of initial state and ground


class Sensors(Block):
    """Turns the true state into a measured one.

    .. pydrake_system::

        name: Sensors
        input_ports:
        - state
        - noise
        output_ports:
        - measured

    A direct feedthrough of both: an update that runs after the plant's step sees the measurement
    of the state after it, as it would see the state. The noise changes in the same step
    (`noise_source`), so every reader of a tick sees the same measurement.
    """

    def __init__(self, humanoid: Humanoid, parameters: SensorParameters) -> None:
        """Declare the ports; `parameters` are the sizes of the noise."""
        super().__init__()
        self.set_name("sensors")
        self._humanoid, self._parameters = humanoid, parameters
        size = humanoid.nq + humanoid.nv
        self._state = self.DeclareVectorInputPort("state", size)
        self._noise = self.DeclareVectorInputPort("noise", state_noise(humanoid))
        self.DeclareVectorOutputPort(
            "measured",
            size,
            weak(self, self._calc_measured),
            prerequisites_of_calc={self._state.ticket(), self._noise.ticket()},
        )

    def _calc_measured(self, context: Context, output: BasicVector) -> None:
        x, noise = self._state.Eval(context), self._noise.Eval(context)
        output.SetFromVector(measured_state(self._humanoid, self._parameters, x, noise))


def measured_state(
    humanoid: Humanoid, parameters: SensorParameters, x: Array, noise: Array
) -> Array:
    """Return the state as the sensors have it.

    Args:
        humanoid: the robot.
        parameters: standard deviations, and the steps of the encoders.
        x: true state [q, v], shape (nq + nv,).
        noise: standard normal numbers for joint angles, joint rates, orientation, angular
            velocity, position and velocity of the torso, shape (2 na + 12,).

    Returns:
        [q, v], shape (nq + nv,). The torso is turned by a random rotation vector; an angle is
        rounded to the encoder's steps after its noise.
    """
    p, na = parameters, humanoid.na
    orientation, gyro, position, velocity = noise[2 * na :].reshape(4, 3)
    y = np.array(x)
    q, v = y[: humanoid.nq], y[humanoid.nq :]
    q[:4] = turned(q[:4], p.orientation * orientation)
    q[4:7] += p.position * position
    v[:3] += p.gyro * gyro
    v[3:6] += p.velocity * velocity
    angles = q[humanoid.actuated_q] + p.joint_position * noise[:na]
    if p.encoder_resolution > 0.0:
        angles = p.encoder_resolution * np.round(angles / p.encoder_resolution)
    q[humanoid.actuated_q] = angles
    v[humanoid.actuated_v] += p.joint_velocity * noise[na : 2 * na]
    return y


def turned(quaternion: Array, vector: Array) -> Array:
    """Return a unit quaternion (w, x, y, z) turned by a rotation vector in its own frame [rad]."""
    half = 0.5 * np.linalg.norm(vector)
    c, s = np.cos(half), 0.5 * np.sinc(half / np.pi) * vector
    w, u = quaternion[0], quaternion[1:]
    return np.concatenate([[w * c - u @ s], w * s + c * u + np.cross(u, s)])


def state_noise(humanoid: Humanoid) -> int:
    """Return how many random numbers the measured state of a robot takes."""
    return 2 * humanoid.na + BASE_NOISE


def noise_source(size: int, period: float) -> RandomSource:
    """Return Drake's source of noise, with a new sample in every step of the plant [s]."""
    source = RandomSource(RandomDistribution.kGaussian, size, period)
    source.set_name("noise")
    return source


def seed_noise(source: RandomSource, context: Context, seed: int) -> None:
    """Let the noise of a source's context follow from a seed."""
    (word,) = np.random.SeedSequence([seed, _NOISE]).generate_state(1)
    source.SetRandomContext(context, RandomGenerator(int(word)))


class Onboard(Block):
    """Turns what is true into what sensors on board say.

    .. pydrake_system::

        name: Onboard
        input_ports:
        - angular_velocity
        - specific_force
        - state
        - net_actuation
        - noise
        output_ports:
        - imu
        - encoders
        - applied_torque

    The discrete state is the biases of the IMU, how many ticks there were, its last sample and
    those on their way, oldest first, and the torque. Without a delay `imu` and `encoders` feed
    through: an update that runs after the plant's step has what holds after it. The torque is
    that of the step before, which belongs to the estimate of the tick before.
    """

    def __init__(self, humanoid: Humanoid, parameters: OnboardParameters, period: float) -> None:
        """Declare ports, state and event; `period` is that of the plant's steps [s]."""
        super().__init__()
        self.set_name("onboard")
        self._p, self._h, na = parameters, period, humanoid.na
        self._every = max(round(1.0 / (parameters.imu_rate * period)), 1)
        self._late = round(parameters.imu_delay / period)
        self._angles = humanoid.actuated_q
        ports = {"angular_velocity": 3, "specific_force": 3, "state": humanoid.nq + humanoid.nv}
        ports |= {"net_actuation": na, "noise": na + IMU_NOISE}
        self._in = {name: self.DeclareVectorInputPort(name, n) for name, n in ports.items()}
        self.DeclareDiscreteState(np.zeros(13 + 6 * self._late + na))
        read = [self._in[name].ticket() for name in ("angular_velocity", "specific_force", "noise")]
        for name, size, calc, tickets in (
            ("imu", 6, self._calc_imu, [self.xd_ticket(), *read]),
            ("encoders", na, self._calc_encoders, [self._in["state"].ticket()]),
            ("applied_torque", na, self._calc_torque, [self.xd_ticket()]),
        ):
            self.DeclareVectorOutputPort(
                name, size, weak(self, calc), prerequisites_of_calc=set(tickets)
            )
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, weak(self, self._update))

    def switch_on(self, context: Context, seed: int, torque: ArrayLike = 0.0) -> None:
        """Give the IMU the biases it has when it is switched on, which follow from a seed.

        Args:
            context: of this system.
            seed: of the biases.
            torque: of the plant's last step [N m], shape (na,); 0 at the beginning.
        """
        random = np.random.default_rng(np.random.SeedSequence([seed, _OFFSETS]))
        sigma = np.repeat([self._p.gyro_offset, self._p.accelerometer_offset], 3)
        state = np.zeros(context.get_discrete_state_vector().size())
        state[:6] = sigma * random.standard_normal(6)
        state[13 + 6 * self._late :] = torque
        context.SetDiscreteState(state)

    def _sample(self, context: Context, state: Array) -> Array:
        """Return the newest sample of the IMU."""
        if state[6] % self._every:
            return state[7:13]
        p, period = self._p, self._every * self._h
        true = [self._in[name].Eval(context) for name in ("angular_velocity", "specific_force")]
        # White noise of a density has its variance over the period.
        sigma = np.repeat([p.gyro_noise, p.accelerometer_noise], 3) / np.sqrt(period)
        noise = sigma * self._in["noise"].Eval(context)[:6]
        most = np.repeat([p.gyro_range, p.accelerometer_range], 3)
        return np.clip(np.concatenate(true) + state[:6] + noise, -most, most)

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        state, p = context.get_discrete_state_vector().value(), self._p
        noise = self._in["noise"].Eval(context)
        walk = np.repeat([p.gyro_walk, p.accelerometer_walk], 3) * np.sqrt(self._h)
        biases, sample = state[:6] + walk * noise[6:12], self._sample(context, state)
        queue = np.concatenate([state[13 : 13 + 6 * self._late], sample])[-6 * self._late :]
        torque = self._in["net_actuation"].Eval(context) + p.torque_noise * noise[IMU_NOISE:]
        queue = queue[: 6 * self._late]
        discrete.set_value(np.concatenate([biases, [state[6] + 1.0], sample, queue, torque]))

    def _calc_imu(self, context: Context, output: BasicVector) -> None:
        state = context.get_discrete_state_vector().value()
        late = 0 < self._late <= state[6]  # before, there is no earlier sample
        output.SetFromVector(state[13:19] if late else self._sample(context, state))

    def _calc_encoders(self, context: Context, output: BasicVector) -> None:
        angles, step = self._in["state"].Eval(context)[self._angles], self._p.encoder_resolution
        output.SetFromVector(step * np.round(angles / step) if step > 0.0 else angles)

    def _calc_torque(self, context: Context, output: BasicVector) -> None:
        state = context.get_discrete_state_vector().value()
        output.SetFromVector(state[13 + 6 * self._late :])
