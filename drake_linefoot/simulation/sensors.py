"""What the controller gets to know of the state: with noise and in steps of the encoders."""

import numpy as np
from pydrake.common import RandomDistribution, RandomGenerator
from pydrake.systems.framework import BasicVector, Context
from pydrake.systems.primitives import RandomSource

from drake_linefoot.leaf_system import Block, weak
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.scenario.disturbances import SensorParameters
from drake_linefoot.types import Array

BASE_NOISE = 12  # random numbers for the base, after two for each joint
_NOISE = 2  # stream of random numbers, beside those of initial state and ground


class Sensors(Block):
    """Turns the true state into a measured one.

    | port | type | shape | unit |
    |---|---|---|---|
    | state | vector | nq + nv | Drake's order; true |
    | noise | vector | 2 na + 12 | standard normal: joints, their rates, torso |
    | measured | vector | nq + nv | Drake's order; for the controller |

    A direct feedthrough of both: an update that runs after the plant's step sees the measurement
    of the state after it, as it would see the state. The noise changes in the same step
    (`noise_source`), so every reader of a tick sees the same measurement.
    """

    def __init__(self, humanoid: Humanoid, parameters: SensorParameters) -> None:
        """Declare the ports.

        Args:
            humanoid: the robot.
            parameters: sizes of the noise.
        """
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
