"""Pushes on the robot's torso as a LeafSystem: on a schedule, and by hand."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike
from pydrake.systems.framework import BasicVector, Context, DiscreteValues

from drake_linefoot.lab.scenario.disturbances import PushParameters
from drake_linefoot.leaf_system import Block, weak
from drake_linefoot.math.rotation import roll_pitch_yaw
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.types import Array

SLACK = 1e-9  # [s] by which times of ticks may be off


class Push(Block):
    """Pushes the torso with forces that last for a while.

    .. pydrake_system::

        name: Push
        input_ports:
        - state
        output_ports:
        - push

    The force is the sum of the pushes of the schedule and of the one by hand. Force and times of
    the latter are parameters of the Context. A push of the schedule keeps the direction it gets
    from the torso's heading when it begins: that heading is the discrete state, one number per
    push, taken by the update of the last `period` before. The update runs after the plant's step,
    so it sees the state at which the push begins. An initialization leaves the headings of pushes
    that have begun as they are.
    """

    def __init__(
        self,
        humanoid: Humanoid,
        schedule: Sequence[PushParameters] = (),
        period: float = 0.001,
    ) -> None:
        """Declare parameters, state, ports and the event.

        Args:
            humanoid: the robot.
            schedule: pushes at given times; they may overlap.
            period: of the plant's steps [s].
        """
        super().__init__()
        self.set_name("push")
        self._schedule = tuple(schedule)
        self._period = period
        self.DeclareNumericParameter(BasicVector(np.zeros(5)))  # force [N], begin, end [s]
        self._state = self.DeclareVectorInputPort("state", humanoid.nq + humanoid.nv)
        tickets = {self.all_parameters_ticket(), self.time_ticket()}
        if self._schedule:
            tickets.add(self.discrete_state_ticket(self.DeclareDiscreteState(len(schedule))))
            self.DeclareInitializationDiscreteUpdateEvent(weak(self, self._begin))
            self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, weak(self, self._follow))
        self.DeclareVectorOutputPort(
            "push", 3, weak(self, self._calc_push), prerequisites_of_calc=tickets
        )

    def push(self, context: Context, force: ArrayLike, duration: float) -> None:
        """Push from now on; takes the place of a push by hand that is still going on.

        Args:
            context: of this system; its time is now.
            force: in W [N], shape (3,).
            duration: of the push [s].
        """
        now = context.get_time()
        values = np.concatenate([np.asarray(force, dtype=float), [now, now + duration]])
        context.get_mutable_numeric_parameter(0).SetFromVector(values)

    def _begin(self, context: Context, discrete: DiscreteValues) -> None:
        """Take the present heading for the pushes that begin now or later."""
        self._aim(context, discrete, context.get_time(), np.inf)

    def _follow(self, context: Context, discrete: DiscreteValues) -> None:
        """Take the heading after the plant's step for the pushes that begin then or soon after."""
        after = context.get_time() + self._period
        self._aim(context, discrete, after, after + 2.0 * self._period)

    def _aim(self, context: Context, discrete: DiscreteValues, start: float, end: float) -> None:
        coming = [start - SLACK < push.time < end for push in self._schedule]
        if any(coming):
            before = context.get_discrete_state_vector().value()
            yaw = roll_pitch_yaw(self._state.Eval(context)[:4])[2]
            discrete.set_value(np.where(coming, yaw, before))

    def _present(self, context: Context) -> Array:
        """Return the force now [N], shape (3,)."""
        now, force = context.get_time(), np.zeros(3)
        by_hand = context.get_numeric_parameter(0).value()
        if _acts(now, by_hand[3], by_hand[4]):
            force += by_hand[:3]
        for k, push in enumerate(self._schedule):
            if _acts(now, push.time, push.time + push.duration):
                angle = context.get_discrete_state_vector().GetAtIndex(k) + push.direction
                force += push.force * np.array([np.cos(angle), np.sin(angle), 0.0])
        return force

    def _calc_push(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._present(context))


def _acts(now: float, begin: float, end: float) -> bool:
    """Whether a push acts during the plant's step that begins `now`; all times in s."""
    return begin - SLACK <= now < end - SLACK
