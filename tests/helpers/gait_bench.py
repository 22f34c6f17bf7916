"""A gait planner alone, whose inputs are set by hand."""

import numpy as np
from pydrake.systems.analysis import Simulator

from drake_linefoot.centroidal import NO_WRENCH
from drake_linefoot.gait.gait_planner import GaitPlanner
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.signals import ContactEstimate
from tests.helpers.ports import look, put
from tests.helpers.walking import dynamics_of

LENGTH = 0.56
WALK = np.array([0.4, 0.1, 0.5, 1.0])


def estimate(left=True, right=True):
    """What an estimator says that feels no force, of the robot of all helpers."""
    flags = np.array([left, right], dtype=float)
    return ContactEstimate(np.zeros((2, 5)), flags, np.zeros(24), NO_WRENCH)


class Bench:
    """A gait planner whose inputs are set by hand."""

    def __init__(self, humanoid, x=None, parameters=None, command=(0.0, 0.0, 0.0, 0.0)):
        self.system = GaitPlanner(humanoid, parameters or GaitParameters(), LENGTH)
        self.simulate()
        self.state(humanoid.x_nominal if x is None else x)
        self.command(command)
        self.contact(True, True)

    def simulate(self, context=None):
        """Start a simulation; from a context that was saved, it goes on."""
        self.simulator = Simulator(self.system, context)
        self.context = self.simulator.get_mutable_context()

    def state(self, x):
        self.dynamics(dynamics_of(x))

    def dynamics(self, d):
        put(self.system, self.context, "dynamics", d)

    def command(self, c):
        self.system.get_command_input_port().FixValue(self.context, c)

    def contact(self, left, right):
        put(self.system, self.context, "contact", estimate(left, right))

    def targets(self):
        return look(self.system.get_targets_output_port(), self.context)

    def horizon(self):
        return look(self.system.get_horizon_output_port(), self.context)

    def until(self, time):
        self.simulator.AdvanceTo(time)
        return self.targets()
