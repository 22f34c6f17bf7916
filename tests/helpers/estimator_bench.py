"""A contact estimator alone, whose inputs are set by hand, and what it sees of a robot at rest."""

import numpy as np
from pydrake.systems.analysis import Simulator

from drake_linefoot.estimation.contact_estimator import ContactEstimator
from drake_linefoot.estimation.contact_parameters import EstimatorParameters
from drake_linefoot.robot.dynamics import robot_dynamics
from tests.helpers.feet import feet_of
from tests.helpers.ports import look, put


class Bench:
    """An estimator with fixed inputs and a simulator that runs nothing else."""

    def __init__(self, robot, x, torque, **parameters):
        self.robot, self.scratch = robot, robot.plant.CreateDefaultContext()
        self.system = ContactEstimator(robot, EstimatorParameters(**parameters))
        self.simulator = Simulator(self.system)
        self.context = self.simulator.get_mutable_context()
        self.feed(x, torque)

    def feed(self, x=None, torque=None):
        if x is not None:
            self.dynamics(robot_dynamics(self.robot, self.scratch, x))
        if torque is not None:
            self.system.get_applied_torque_input_port().FixValue(self.context, torque)

    def dynamics(self, d):
        put(self.system, self.context, "dynamics", d)

    def estimate(self):
        return look(self.system.get_contact_output_port(), self.context, self.robot)

    def after(self, time):
        self.simulator.AdvanceTo(time)
        return self.estimate()


def standing(robot, lean=0.0):
    """Return (x, torque, wrench) of a posture at rest: what holds it there.

    Both legs lean to one side by an angle, so that one foot carries more. Feet at one
    height cannot choose how to share the weight; the least forces along the middles of the
    feet that the six base rows of the statics allow are taken, and the joint rows say which
    torque goes with them.
    """
    x = robot.x_nominal
    left, right = robot.leg_q[:, 1]  # the joints about the forward axis
    x[left] = lean
    x[right] = -robot.mirror_state(x)[right]
    context = robot.plant.CreateDefaultContext()
    robot.plant.SetPositionsAndVelocities(context, x)
    d = robot_dynamics(robot, context, x)
    gravity = robot.plant.CalcGravityGeneralizedForces(context)
    wrench = np.zeros((2, robot.contact.size))
    J = np.vstack([foot.J[:5] for foot in feet_of(d)])
    forces = np.linalg.lstsq(J[:, :6].T, -gravity[:6], rcond=None)[0]
    torque = -(gravity + J.T @ forces)[robot.actuated_v]
    wrench[:, :5] = forces.reshape(2, 5)
    return x, torque, wrench
