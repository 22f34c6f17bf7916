"""The reference of the MPC: pendulum for the CoM; momentum and inertia as the model has them."""

import numpy as np

from drake_linefoot.errors import InputError
from drake_linefoot.layout import Layout
from drake_linefoot.mpc.models.motion import Robot, desired_motion
from drake_linefoot.mpc.models.reaching import determinant
from drake_linefoot.mpc.models.registry import model_named
from drake_linefoot.mpc.parameters import MpcParameters
from drake_linefoot.robot.arms import arm_turns
from drake_linefoot.robot.dynamics import dynamics_layout
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.leg_inertia import LegInertia
from drake_linefoot.robot.legs import read_legs
from drake_linefoot.signals import GaitHorizon, Reference, RobotDynamics
from drake_linefoot.types import Array

AS_IT_IS = ("friction", "external", "coming", "footholds")  # taken from the horizon


class ReferenceGenerator:
    """Turns the gait into the reference of the MPC.

    CoM, torso and feet move as the gait plans; what inertia and angular momentum go with that, and
    where the knots are, is up to the model.

    Attributes:
        dynamics, horizon, reference: layouts of the vectors that are taken and given.
    """

    def __init__(self, humanoid: Humanoid, parameters: MpcParameters) -> None:
        """Keep parameters, and what is to know of the robot.

        Raises:
            InputError: the parameters name an unknown model.
        """
        self._parameters, sizes = parameters, {"knots": parameters.knots}
        self.dynamics = dynamics_layout(humanoid)
        self.horizon, self.reference = Layout(GaitHorizon, sizes), Layout(Reference, sizes)
        legs, leg_q, q = read_legs(humanoid), humanoid.leg_q, humanoid.q_nominal
        self._inertia, nominal = LegInertia(humanoid, legs), determinant(legs, q[leg_q])
        masses = self._inertia.masses(q)
        self._robot = Robot(
            legs, masses, leg_q, humanoid.mass, nominal, humanoid.arm_v, arm_turns(humanoid), 0.0,
            humanoid.nv, humanoid.contact.size,
        )  # fmt: skip
        self._model = model_named(parameters.model)
        places = np.arange(max(self.horizon.size, self.reference.size))
        self._from, self._to = (
            np.concatenate([places[layout.place(name)] for name in AS_IT_IS])
            for layout in (self.horizon, self.reference)
        )
        self._arm_swing = self.horizon.place("arm_swing").start
        self._reach = self.reference.place("reach_error").start

    def vector(self, horizon: Array, dynamics: Array) -> Array:
        """Return the vector of the reference over the horizon.

        Args:
            horizon: vector of the gait's `GaitHorizon`.
            dynamics: vector of the `RobotDynamics` of the present state.
        """
        d, flat, nw = self.dynamics.open(dynamics), np.zeros(self.reference.size), self._robot.nw
        lines = desired_motion(flat, horizon, self.knots(self.horizon.open(horizon)), d.p_WG, nw)
        reach = self._model.write_reference(flat, lines, dynamics, self._robot_now(horizon, d))
        flat[self._to] = horizon[self._from]
        flat[self._reach] = reach
        return flat

    def _robot_now(self, horizon: Array, d: RobotDynamics) -> Robot:
        """Return what is to know of the robot in its present state."""
        masses, swing = self._inertia.masses(d.q), float(horizon[self._arm_swing])
        return self._robot._replace(masses=masses, arm_swing=swing)

    def generate(self, horizon: GaitHorizon, d: RobotDynamics) -> Reference:
        """Return what `vector` does, of signals that are open."""
        vectors = self.horizon.vector(horizon), self.dynamics.vector(d)
        return self.reference.open(self.vector(*vectors))

    def knots(self, horizon: GaitHorizon) -> Array:
        """Return the knots of the MPC [s], shape (K + 1,): no foot switches between two.

        The first is when the plan begins to be used.

        Raises:
            InputError: the model gives another number of them.
        """
        p = self._parameters
        begin = horizon.time + p.lead
        found = self._model.knots(horizon, begin, p.knots, p.knot_step, p.period)
        if found.shape != (p.knots + 1,):
            allowed = f"must be {p.knots + 1} knots"
            raise InputError(f"model {self._model.name}", "knots", found.shape, allowed)
        return found
