"""The reference of the MPC: pendulum for the CoM, inverse kinematics for the legs."""

from collections.abc import Callable

import numpy as np

from drake_linefoot.gait.schedule import knots, phases_until
from drake_linefoot.layout import Layout
from drake_linefoot.reference.contact_consistent import (
    consistent_knots,
    consistent_legs,
    determinant,
)
from drake_linefoot.reference.locked_legs import locked_legs
from drake_linefoot.reference.motion import Robot, desired_motion
from drake_linefoot.reference.parameters import CONTACT_CONSISTENT, ECD, ReferenceParameters
from drake_linefoot.reference.planned_legs import planned_legs
from drake_linefoot.robot.dynamics import dynamics_layout
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.leg_inertia import LegInertia
from drake_linefoot.robot.legs import read_legs
from drake_linefoot.signals import GaitHorizon, Reference, RobotDynamics
from drake_linefoot.types import Array

LEGS: dict[str, Callable[..., float]] = {CONTACT_CONSISTENT: consistent_legs, ECD: planned_legs}
AS_IT_IS = ("slope", "friction", "external", "coming", "footholds")  # taken from the horizon


class ReferenceGenerator:
    """Turns the gait into the reference of the MPC.

    With the model "ecd" inertia and angular momentum follow the planned legs; with
    "contact_consistent" the torso's rate does, too, with feet that go as planned; with
    "srbm" and "srbm_momentum" the inertia is frozen at its present value and the joints
    count as locked.

    Attributes:
        dynamics, horizon, reference: layouts of the vectors that are taken and given.
    """

    def __init__(self, humanoid: Humanoid, parameters: ReferenceParameters) -> None:
        """Keep parameters, and what is to know of the robot."""
        self._parameters, sizes = parameters, {"knots": parameters.knots}
        self.dynamics = dynamics_layout(humanoid)
        self.horizon, self.reference = Layout(GaitHorizon, sizes), Layout(Reference, sizes)
        legs, leg_q, q = read_legs(humanoid), humanoid.leg_q, humanoid.q_nominal
        self._inertia, nominal = LegInertia(humanoid, legs), determinant(legs, q[leg_q])
        masses = self._inertia.masses(q)
        self._robot = Robot(
            legs, masses, leg_q, humanoid.mass, nominal, humanoid.nv, humanoid.contact.size
        )
        self._write = LEGS.get(parameters.model, locked_legs)
        places = np.arange(max(self.horizon.size, self.reference.size))
        self._from, self._to = (
            np.concatenate([places[layout.place(name)] for name in AS_IT_IS])
            for layout in (self.horizon, self.reference)
        )
        self._reach, self._turns = (
            self.reference.place(name).start for name in ("reach_error", "turns")
        )

    def vector(self, horizon: Array, dynamics: Array) -> Array:
        """Return the vector of the reference over the horizon.

        Args:
            horizon: vector of the gait's `GaitHorizon`.
            dynamics: vector of the `RobotDynamics` of the present state.
        """
        d, flat = self.dynamics.open(dynamics), np.zeros(self.reference.size)
        lines = desired_motion(flat, horizon, self.knots(self.horizon.open(horizon)), d.p_WG)
        robot = self._robot._replace(masses=self._inertia.masses(d.q))
        reach = self._write(flat, lines, dynamics, robot)
        flat[self._to] = horizon[self._from]
        flat[self._reach] = reach
        flat[self._turns] = float(self._parameters.model == CONTACT_CONSISTENT)
        return flat

    def generate(self, horizon: GaitHorizon, d: RobotDynamics) -> Reference:
        """Return what `vector` does, of signals that are open."""
        vectors = self.horizon.vector(horizon), self.dynamics.vector(d)
        return self.reference.open(self.vector(*vectors))

    def knots(self, horizon: GaitHorizon) -> Array:
        """Return the knots of the MPC [s], shape (K + 1,): no foot switches between two.

        The first is when the plan begins to be used. With "contact_consistent" the first interval
        ends just after that use: how a swinging leg turns the torso changes that fast.
        """
        p, begin = self._parameters, horizon.time + self._parameters.lead
        if p.model == CONTACT_CONSISTENT:
            ends = phases_until(horizon)
            return consistent_knots(ends, begin, p.knots, p.knot_step, p.period)
        return knots(horizon, begin, p.knots, p.knot_step)
