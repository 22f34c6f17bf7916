"""The sensors on board: what an IMU, encoders and motor currents say of the robot."""

import numpy as np
from numpy.typing import ArrayLike
from pydrake.systems.framework import BasicVector, Context, DiscreteValues

from drake_linefoot.estimation.parameters import OnboardParameters
from drake_linefoot.leaf_system import Block, weak
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.types import Array

IMU_NOISE = 12  # random numbers of the IMU: of its readings, and of its biases; then the torques
_OFFSETS = 4  # stream of random numbers, beside those of `sensors`


class Onboard(Block):
    """Turns what is true into what sensors on board say.

    | port | type | shape | unit |
    |---|---|---|---|
    | angular_velocity | vector | 3 | rad/s, in B, of Drake's Gyroscope |
    | specific_force | vector | 3 | m/s^2, in B, of Drake's Accelerometer |
    | state | vector | nq + nv | Drake's order; true, for the encoders |
    | net_actuation | vector | na | N m, of the plant's last step |
    | noise | vector | na + 12 | standard normal: IMU, its biases, torques |
    | imu | vector | 6 | rad/s, m/s^2, in B |
    | encoders | vector | na | rad |
    | applied_torque | vector | na | N m, as the currents have it, a tick late |

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
        state = np.zeros(context.get_discrete_state_vector().size())
        state[:6] = offsets(self._p, seed)
        state[13 + 6 * self._late :] = torque
        context.SetDiscreteState(state)

    def _sample(self, context: Context, state: Array) -> Array:
        """Return the newest sample of the IMU."""
        if state[6] % self._every:
            return state[7:13]
        true = [self._in[name].Eval(context) for name in ("angular_velocity", "specific_force")]
        noise = self._in["noise"].Eval(context)[:6]
        return imu_sample(self._p, np.concatenate(true) + state[:6], noise, self._every * self._h)

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


def imu_sample(p: OnboardParameters, values: Array, noise: Array, period: float) -> Array:
    """Return a sample of the IMU, angular velocity and specific force, shape (6,).

    Args:
        p: what it is like.
        values: with their biases [rad/s, m/s^2], shape (6,).
        noise: standard normal numbers, shape (6,).
        period: between two samples [s]; white noise of a density has its variance over it.
    """
    sigma = np.repeat([p.gyro_noise, p.accelerometer_noise], 3) / np.sqrt(period)
    most = np.repeat([p.gyro_range, p.accelerometer_range], 3)
    return np.clip(values + sigma * noise, -most, most)


def offsets(p: OnboardParameters, seed: int) -> Array:
    """Return the biases of the IMU when it is switched on [rad/s, m/s^2], shape (6,)."""
    random = np.random.default_rng(np.random.SeedSequence([seed, _OFFSETS]))
    sigma = np.repeat([p.gyro_offset, p.accelerometer_offset], 3)
    return sigma * random.standard_normal(6)
