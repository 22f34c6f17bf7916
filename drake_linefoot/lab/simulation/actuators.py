"""What becomes of the controller's torque: delay, torque-speed curve, friction of the joints."""

import numpy as np
from pydrake.systems.framework import BasicVector, Context, EventStatus, State

from drake_linefoot.lab.scenario.disturbances import ActuatorParameters
from drake_linefoot.leaf_system import Block, weak
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.types import Array

FRICTION_SPEED = 0.1  # [rad/s] at which Coulomb friction has 3/4 of its size


class Actuators(Block):
    """Applies the controller's torque as motors do: late, and less at speed.

    .. pydrake_system::

        name: Actuators
        input_ports:
        - torque
        - state
        output_ports:
        - actuation

    With a delay of n steps the actuation of step k comes from the torque of step k - n; for the
    first n steps, which have no earlier one, from the torque of their own. The torques on their
    way are the discrete state, oldest first, NaN where there is none. An unrestricted update
    takes them in: it runs together with the plant's step and sees the torque of that step.
    Drake's DiscreteTimeDelay would take in the one of the state after it, which the controller
    has to compute twice.
    """

    def __init__(
        self,
        humanoid: Humanoid,
        parameters: ActuatorParameters,
        friction: float = 0.0,
        period: float = 0.001,
    ) -> None:
        """Declare ports, state and event.

        Args:
            humanoid: the robot.
            parameters: delay and torque-speed curve.
            friction: Coulomb friction of every joint [N m].
            period: of the plant's steps [s].
        """
        super().__init__()
        self.set_name("actuators")
        self._parameters, self._friction = parameters, friction
        self._effort, self._fastest = humanoid.effort_limits, humanoid.velocity_limits
        self._speeds = humanoid.nq + humanoid.actuated_v
        self._steps, self._na = round(parameters.delay / period), humanoid.na
        self._torque = self.DeclareVectorInputPort("torque", humanoid.na)
        self._state = self.DeclareVectorInputPort("state", humanoid.nq + humanoid.nv)
        tickets = {self._torque.ticket(), self._state.ticket()}
        if self._steps:
            nothing = np.full(self._steps * humanoid.na, np.nan)
            tickets.add(self.discrete_state_ticket(self.DeclareDiscreteState(nothing)))
            self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, weak(self, self._take_in))
        self.DeclareVectorOutputPort(
            "actuation",
            humanoid.na,
            weak(self, self._calc_actuation),
            prerequisites_of_calc=tickets,
        )

    def _take_in(self, context: Context, state: State) -> EventStatus:
        """Let the oldest torque go and take in that of the present step."""
        on_their_way = context.get_discrete_state_vector().value()
        torques = np.concatenate([on_their_way[self._na :], self._torque.Eval(context)])
        state.get_mutable_discrete_state().set_value(torques)
        return EventStatus.Succeeded()

    def _calc_actuation(self, context: Context, output: BasicVector) -> None:
        p, torque = self._parameters, None
        if self._steps:
            torque = context.get_discrete_state_vector().value()[: self._na].copy()
        if torque is None or np.isnan(torque).any():
            torque = self._torque.Eval(context)
        speed = self._state.Eval(context)[self._speeds]
        if p.torque_speed:
            bounds = torque_bounds(self._effort, self._fastest, p.base_speed_share, speed)
            torque = np.clip(torque, *bounds)
        if self._friction:
            torque = torque - coulomb_friction(self._friction, speed)
        output.SetFromVector(torque)


def torque_bounds(
    effort: Array, fastest: Array, base_speed_share: float, speed: Array
) -> tuple[Array, Array]:
    """Return the least and the largest torque that motors give at a speed [N m].

    Up to the base speed a motor gives its full effort; from there what drives it on falls
    linearly, to nothing at its largest speed. What brakes it is always the full effort.

    Args:
        effort: largest torques [N m], shape (n,).
        fastest: speeds without load [rad/s], shape (n,).
        base_speed_share: of the largest speed, in [0, 1).
        speed: of the joints [rad/s], shape (n,).

    Returns:
        Lower and upper bounds, shape (n,) each.
    """
    fall = fastest * (1.0 - base_speed_share)
    upper = effort * np.clip((fastest - speed) / fall, 0.0, 1.0)
    lower = -effort * np.clip((fastest + speed) / fall, 0.0, 1.0)
    return lower, upper


def coulomb_friction(size: float, speed: Array) -> Array:
    """Return the friction torque that a joint's motion has to overcome [N m], shape (n,).

    Args:
        size: at high speed [N m].
        speed: of the joints [rad/s], shape (n,). The friction is smooth around rest, so a joint
            at rest creeps under a load below its size.
    """
    return size * np.tanh(speed / FRICTION_SPEED)
