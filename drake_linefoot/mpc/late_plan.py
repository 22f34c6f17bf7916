"""The plan that is used when one takes as long as its period: the one before."""

import numpy as np
from pydrake.systems.framework import Context, EventStatus, State

from drake_linefoot.leaf_system import Block, weak


class LatePlan(Block):
    """Holds the plan of one period ago.

    .. pydrake_system::

        name: LatePlan
        input_ports:
        - newest
        output_ports:
        - plan

    Its update at the time of each of the MPC sees the plan before that one, as all unrestricted
    updates of a time see what was before it. A simulation begins with the plan with which the MPC
    does; a state that was saved goes on.
    """

    def __init__(self, size: int, period: float) -> None:
        """Declare ports, state and events; `size` of a plan's vector, `period` of the MPC [s]."""
        super().__init__()
        self.set_name("late_plan")
        self._newest = self.DeclareVectorInputPort("newest", size)
        plan = self.DeclareDiscreteState(size)
        self._begun = self.DeclareDiscreteState(1)
        self.DeclareStateOutputPort("plan", plan)
        self.DeclareInitializationUnrestrictedUpdateEvent(weak(self, self._begin))
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, weak(self, self._update))

    def _begin(self, context: Context, state: State) -> EventStatus:
        if context.get_discrete_state(self._begun).value()[0]:
            return EventStatus.DidNothing()
        return self._update(context, state)

    def _update(self, context: Context, state: State) -> EventStatus:
        for group, values in enumerate((self._newest.Eval(context), np.ones(1))):
            state.get_mutable_discrete_state(group).set_value(values)
        return EventStatus.Succeeded()
