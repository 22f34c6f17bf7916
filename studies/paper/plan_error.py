"""How far off a plan's torso is along its horizon, against the kinematics of the full body.

From the state of one update every model makes its plan. The exact torso is that of the full body
over feet and arms that move as the gait plans, with CoM and angular momentum of the plan. Where a
swing foot is not where the gait means it to be, the kinematics begin as the models do, with the
foot in its place.
"""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np

from drake_linefoot.centroidal import sample_plan
from drake_linefoot.gait.schedule import feet_motion, slopes_at
from drake_linefoot.math.rotation import rotation_error
from drake_linefoot.mpc.models.motion import line_plan
from drake_linefoot.mpc.models.registry import model_named
from drake_linefoot.mpc.parameters import MpcParameters
from drake_linefoot.mpc.reference import ReferenceGenerator
from drake_linefoot.mpc.solve import MpcSolver
from drake_linefoot.robot.arms import arm_turns
from drake_linefoot.robot.dynamics import robot_dynamics
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.scaling import scaled, units_of
from drake_linefoot.signals import CentroidalPlan, GaitHorizon, RobotDynamics
from studies.common.types import Array
from studies.paper.full_body import FullBody, Motion

MODELS = ("contact_consistent", "ecd", "srbm")
TIMES = (0.02, 0.10, 0.25, 0.40)  # [s] into the plan, of the MIT Humanoid; of others in their size
STEP = 0.01  # [s] of the integration at most, likewise


class Planners:
    """Every model of the MPC for one robot, and what its plans are compared with."""

    def __init__(self, humanoid: Humanoid, parameters: MpcParameters) -> None:
        """Make the models; their parameters are alike but for the name."""
        self._h, self._body, self._turns = humanoid, FullBody(humanoid), arm_turns(humanoid)
        self._second, self._made = units_of(humanoid)["s"], {}
        for name in MODELS:
            p = scaled(replace(parameters, model=name), humanoid)
            solver = MpcSolver(p, humanoid.mass, humanoid.contact)
            self._made[name] = ReferenceGenerator(humanoid, p), solver, model_named(name).measure

    def errors(self, x: Array, horizon: GaitHorizon) -> dict[str, Array]:
        """Return how far the orientation of each model's plan is off [rad], at `TIMES`.

        Args:
            x: state at an update of the MPC, shape (nq + nv,).
            horizon: of the gait then.

        Returns:
            Norm of the difference of both rotation vectors from the desired torso, by model, shape
            (4,). NaN beyond the end of the plan, where the full body cannot follow, and where the
            program is not solved.
        """
        d, found = robot_dynamics(self._h, self._body.context, x), {}
        for name, (generator, solver, measure) in self._made.items():
            reference = generator.generate(horizon, d)
            plan = solver.solve(reference, measure(d))
            off = np.full((len(plan.times), 3), np.nan)
            if plan.success:
                times, at = stages(plan.times, self._second * STEP)
                R = self._body.torso(d.q, self.motion(d, horizon, plan, times))[at]
                for k in np.flatnonzero(np.isfinite(R[:, 0, 0])):
                    off[k] = plan.states[k, 9:] - rotation_error(R[k], reference.R[k])
            since = plan.times - plan.times[0]
            wanted = self._second * np.array(TIMES)
            there = [np.interp(wanted, since, of, right=np.nan) for of in off.T]
            found[name] = np.linalg.norm(there, axis=0)
        return found

    def motion(
        self, d: RobotDynamics, horizon: GaitHorizon, plan: CentroidalPlan, times: Array
    ) -> Motion:
        """Return what a plan asks the full body to do.

        Args:
            d: of the state it starts from.
            horizon: of the gait.
            plan: of any model.
            times: increasing [s], shape (n,).
        """
        feet = feet_motion(horizon, times)
        lines = line_plan(feet, slopes_at(horizon, times), self._h.contact.size)
        samples = [sample_plan(plan, t) for t in times]
        r, v, L = (np.array([s[i] for s in samples]) for i in (0, 1, 3))
        yaw = horizon.yaw + horizon.turn_rate * (times - horizon.time)
        ahead = np.column_stack([np.cos(yaw), np.sin(yaw), np.zeros(len(yaw))])
        swing, rate = (
            horizon.arm_swing * np.sum(ahead * (of[1] - of[0]), axis=1) for of in (lines.p, lines.v)
        )
        return Motion(
            times, r, v, L, lines.p, lines.R[..., 0], lines.v, lines.w,
            d.q[self._h.arm_q] + np.outer(swing - swing[0], self._turns),
            np.outer(rate, self._turns),
        )  # fmt: skip


def stages(knots: Array, step: float) -> tuple[Array, Array]:
    """Return times of an integration whose steps end at the knots.

    Args:
        knots: [s], shape (K + 1,).
        step: at most [s].

    Returns:
        Begins, middles and ends of the steps [s]; and which begin or end each knot is, shape
        (K + 1,).
    """
    pieces = [(a, b, math.ceil((b - a) / step - 1e-9)) for a, b in pairwise(knots)]
    parts = [np.linspace(a, b, 2 * n, endpoint=False) for a, b, n in pieces]
    return np.concatenate([*parts, knots[-1:]]), np.cumsum([0, *(n for *_, n in pieces)])
