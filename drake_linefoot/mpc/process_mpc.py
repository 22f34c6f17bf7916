"""The model-predictive controller in a process of its own, beside the ticks of the rest."""

import math

import numpy as np
from pydrake.systems.framework import Context, EventStatus, State

from drake_linefoot.leaf_system import read_vector
from drake_linefoot.mpc.ecd_mpc import EcdMpc
from drake_linefoot.mpc.parameters import MpcParameters
from drake_linefoot.mpc.worker import Worker, pack
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.statuses import Solved


class ProcessMpc(EcdMpc):
    """Plans as `EcdMpc`, but in another process: each plan is used one period later.

    .. pydrake_system::

        name: ProcessMpc
        input_ports:
        - dynamics
        - reference
        output_ports:
        - plan

    An update takes the plan of the problem of the one before, and gives the process the next one:
    plans are those of `MpcParameters.late`, to the bit. What was asked is in the discrete state, so
    that a context may be copied or set back. A plan that is not there within `patience` is waited
    for without holding up anything: the previous one goes on, `Solved.LATE`, and it is counted as
    one that failed; so it is while a process that has ended is begun anew.

    Attributes:
        patience: so long after it was asked a plan is waited for, of the clock on the wall [s];
            endless at first, as in simulation.
    """

    def __init__(self, humanoid: Humanoid, parameters: MpcParameters) -> None:
        """Declare what `EcdMpc` does, with its arguments and errors, and begin the process."""
        super().__init__(humanoid, parameters)
        self.patience = math.inf
        self.worker = Worker(self.setting)
        sizes = [layout.size for layout in self.layouts.values()]
        self._asked = self.DeclareDiscreteState(1 + len(self.parameter_names) + sum(sizes))

    def _update(self, context: Context, state: State) -> EventStatus:
        plan = context.get_discrete_state(0).value().copy()
        asked = context.get_discrete_state(self._asked).value()
        if asked[0]:
            answer = self.worker.answer(asked[1:], self.patience)
            if answer is None:
                layout = self.layouts["plan"]
                held = layout.open(plan)
                late = held._replace(status=float(Solved.LATE), failures=held.failures + 1.0)
                state.get_mutable_discrete_state(0).set_value(layout.vector(late))
                return EventStatus.Succeeded()
            plan = answer
        d, reference = (read_vector(self, port, context, of) for port, of in self.signals)
        problem = pack(context.get_numeric_parameter(0).value(), d, reference, plan)
        self.worker.ask(problem)
        state.get_mutable_discrete_state(0).set_value(plan)
        state.get_mutable_discrete_state(self._asked).set_value(np.append(1.0, problem))
        return EventStatus.Succeeded()
