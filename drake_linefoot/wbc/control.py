"""One tick of the whole-body controller: (49)-(53)."""

import time
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from drake_linefoot.centroidal import free_fall, sample_plan
from drake_linefoot.layout import Layout
from drake_linefoot.math.compiled import as_python, compiled, inlined
from drake_linefoot.parts import KNOTS
from drake_linefoot.robot.arms import arm_turns
from drake_linefoot.robot.dynamics import dynamics_layout
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.scaling import scaled
from drake_linefoot.signals import (
    CentroidalPlan,
    GaitTargets,
    RobotDynamics,
    WholeBodyReport,
    fill_report,
    open_dynamics,
    open_plan,
    open_targets,
)
from drake_linefoot.statuses import Solved
from drake_linefoot.types import Array
from drake_linefoot.wbc.constants import Constants, Packed, constants_of, opened, packed
from drake_linefoot.wbc.joint_limits import acceleration_within_limits
from drake_linefoot.wbc.parameters import WbcParameters
from drake_linefoot.wbc.tasks.stack import stacked_tasks
from drake_linefoot.wbc.tasks.task import Task, arms_left, own_rows
from drake_linefoot.wbc.torque_limits import solve_by, solve_limited, torque_rows
from drake_linefoot.wbc.wrench_qp import (
    WrenchProgram,
    WrenchSolver,
    solve_program,
    wrench_program,
)

NO_CONTACT, UNCONSTRAINED, ACTIVE_SET = (  # as compiled code takes them
    float(status) for status in (Solved.NO_CONTACT, Solved.UNCONSTRAINED, Solved.ACTIVE_SET)
)


class Effort(NamedTuple):
    """What the joints do.

    Attributes:
        torque: within the limits [N m], shape (na,).
        clipped: torques that were not.
        wrench: of both feet, zero in the air [N, N m], shape (2, nw).
        wrench_error: its difference from the MPC's, delta_fr of (49), shape (2, nw).
        acceleration_error: delta_f of (49), shape (6,).
        vdot: acceleration that comes of it, shape (nv,).
    """

    torque: Array
    clipped: int
    wrench: Array
    wrench_error: Array
    acceleration_error: Array
    vdot: Array


@compiled
def joint_effort(
    d: RobotDynamics,
    vdot: Array,
    program: WrenchProgram,
    delta: Array,
    contact: tuple[bool, bool],
    c: Constants,
) -> Effort:
    """Return what the joints must give, ``M vdot + Cv - tau_g - sum J_i' w_i``.

    Args:
        d: present quantities.
        vdot: commanded acceleration, shape (nv,).
        program: (49).
        delta: corrections that solve it, shape (nw n,).
        contact: whether the left and the right foot stand.
        c: constants.
    """
    nw, at = d.J.shape[1], 0
    wrench, error = np.zeros((2, nw)), np.zeros((2, nw))
    for side in range(2):
        if contact[side]:
            error[side] = delta[nw * at : nw * at + nw]
            wrench[side] = program.u[at] + error[side]
            at += 1
    delta_f, vdot = program.G @ delta + program.c, vdot.copy()
    vdot[:6] += delta_f
    J = d.J.reshape(2 * nw, len(vdot))
    needed = d.M @ vdot + d.Cv - d.tau_g - wrench.reshape(2 * nw) @ J
    torque, clipped = np.empty(len(c.actuated_v)), 0
    for k in range(len(torque)):
        tau, limit = needed[c.actuated_v[k]], c.effort_limits[k]
        torque[k] = min(max(tau, -limit), limit)
        clipped += int(torque[k] != tau)
    return Effort(torque, clipped, wrench, error, delta_f, vdot)


@compiled
def control_tick(
    dynamics: Array,
    targets: Array,
    plan: Array,
    own: Array,
    knots: int,
    c: Packed,
    report: Array,
) -> tuple[tuple[int, int, bool, bool], tuple[Array, tuple[Array, ...]]]:
    """Write the report of a tick as far as it goes without a solver.

    Takes signals as they travel, and plain tuples: a NamedTuple costs 1 us each time it comes from
    Python or goes there, and with those inside the constants there would be twelve.

    Args:
        dynamics: `RobotDynamics`.
        targets: `GaitTargets`.
        plan: `CentroidalPlan`.
        own: rows of one's own tasks, see `own_rows`, shape (m, nv + 2).
        knots: intervals of the plan.
        c: `Constants`, with those inside as tuples, too.
        report: `WholeBodyReport`, written.

    Returns:
        ((dropped, active, positive, solved), (vdot, program)): task rows that were dropped, rows of
        the cones that the solution touches, whether the mass matrix is positive definite, whether
        the program (49) was solved; without that the report is not one to use. The acceleration
        that meets the tasks, shape (nv,), and fields of `WrenchProgram`.
    """
    k = opened(c)
    na, nw = len(k.actuated_v), len(k.weights.Q1)
    d, t = open_dynamics(dynamics, na + 6, nw), open_targets(targets)
    contact = (t.contact[0] > 0.5, t.contact[1] > 0.5)
    swings = (t.swings[0] > 0.5, t.swings[1] > 0.5)
    sample, ground = (
        sample_plan(open_plan(plan, knots, nw), t.time),
        (t.slope, t.friction, t.friction_share),
    )
    if not (contact[0] or contact[1]):
        sample = free_fall(sample, d, t.external, k.mass)
    feet = contact, swings, t.swing, t.slope
    tasks, places = stacked_tasks(d, feet, sample, k.mass, k.gains, (k.arms, t.arms), own)
    vdot, dropped, positive = acceleration_within_limits(
        d, tasks, places, (contact, swings), k.limits
    )
    p = wrench_program(d, vdot, contact, sample.wrench, ground, t.external, k.weights)
    delta, active, solved = solve_program(p, k.weights.weight)
    e = joint_effort(d, vdot, p, delta, contact, k)
    if solved and e.clipped and len(delta):
        rows = torque_rows(d, vdot, p, contact, k.actuated_v)
        delta, active, solved = solve_limited(
            p, rows, delta, k.effort_limits, k.weights.slack, k.weights.weight
        )
        e = joint_effort(d, vdot, p, delta, contact, k)
    fill_report(report, as_report(e, active, dropped, contact[0] or contact[1]), na, na + 6, nw)
    return (dropped, active, positive, solved), (vdot, (p.H, p.g, p.W, p.u, p.G, p.c))


@inlined
def as_report(e: Effort, active: int, dropped: int, stands: bool) -> WholeBodyReport:
    """Return an effort as a report; `stands` is whether a foot does."""
    status = ACTIVE_SET if active else (UNCONSTRAINED if stands else NO_CONTACT)
    return WholeBodyReport(
        e.torque, e.wrench, e.wrench_error, e.acceleration_error, e.vdot, status, float(active),
        float(dropped), float(e.clipped), 0.0,
    )  # fmt: skip


class WholeBodyControl:
    """State and plans in, joint torques out: (49)-(53).

    Attributes:
        constants: what does not change from tick to tick.
        solver: of programs (49) that the active-set method leaves.
        tasks: of one's own, in the order of their priority.
        dynamics, targets, plan, report: layouts of what comes and goes.
    """

    def __init__(
        self,
        humanoid: Humanoid,
        parameters: WbcParameters,
        knots: int = KNOTS,
        tasks: Sequence[Task] = (),
    ) -> None:
        """Keep the robot.

        Args:
            humanoid: the robot.
            parameters: gains and weights.
            knots: intervals of the plans.
            tasks: of one's own.

        Raises:
            InputError: the parameters name an unknown solver; two tasks have one name; a task
                decides a joint that is not of the arms.
        """
        p, h = scaled(parameters, humanoid), humanoid
        self._humanoid, self._turns = humanoid, arm_turns(humanoid)
        self.tasks, self._arms = sorted(tasks, key=lambda task: task.priority), arms_left(h, tasks)
        self.solver = WrenchSolver(p, h.mass, h.contact)
        self.constants = constants_of(p, h, self._arms, self._turns)
        self.dynamics, sizes = dynamics_layout(h), h.sizes | {"knots": knots}
        self.targets, self.report = Layout(GaitTargets, sizes), Layout(WholeBodyReport, sizes)
        self.plan, self._nothing = Layout(CentroidalPlan, sizes), np.empty((0, h.nv + 2))
        self._packed = packed(self.constants)

    def packed(self, parameters: WbcParameters) -> Packed:
        """Return the constants of other parameters, in the size of the robot, for `compute`."""
        return packed(constants_of(parameters, self._humanoid, self._arms, self._turns))

    def compute(
        self, dynamics: Array, targets: Array, plan: Array, constants: Packed | None = None
    ) -> Array:
        """Return torques and how they came about, a `WholeBodyReport` as it travels.

        Args:
            dynamics: quantities of the present state, `RobotDynamics`.
            targets: which feet stand, and where swing feet should be, `GaitTargets`.
            plan: the MPC's, `CentroidalPlan`.
            constants: see `packed`; those of the parameters without.

        Raises:
            numpy.linalg.LinAlgError: the mass matrix is not positive definite.
            InputError: rows of one's own task do not fit the robot, or are not finite.
        """
        started, report, own = time.perf_counter(), np.empty(self.report.size), self._nothing
        c = constants or self._packed
        if self.tasks:
            own = own_rows(self.tasks, self.dynamics.open(dynamics), self.targets.open(targets))
        outcome, (vdot, program) = control_tick(
            dynamics, targets, plan, own, self.plan.sizes["knots"], c, report
        )
        dropped, _, positive, solved = outcome
        if not positive:
            raise np.linalg.LinAlgError("the mass matrix is not positive definite")
        if not solved:
            d, t = self.dynamics.open(dynamics), self.targets.open(targets)
            other = self._solved(d, t, vdot, WrenchProgram(*program), as_python(opened)(c))
            report = self.report.vector(other._replace(dropped_rows=float(dropped)))
        report[-1] = 1e3 * (time.perf_counter() - started)
        return report

    def _solved(
        self,
        d: RobotDynamics,
        targets: GaitTargets,
        vdot: Array,
        program: WrenchProgram,
        c: Constants,
    ) -> WholeBodyReport:
        """Return what comes of the program by the solver, or of the MPC's wrench when it fails."""
        stand = targets.contact > 0.5
        contact = bool(stand[0]), bool(stand[1])
        rows = torque_rows(d, vdot, program, contact, c.actuated_v)
        delta, status = solve_by(self.solver, program, rows, c.effort_limits, c.weights.slack)
        if not status.success:
            t = targets
            friction = min(c.weights.friction, t.friction)
            ground = d.R_WC[stand], t.slope[stand], friction, t.friction_share[stand]
            moved = self.solver.inside_cones(program.u, *ground)
            delta = (moved - program.u).ravel()
        effort = joint_effort(d, vdot, program, delta, contact, c)
        return as_python(as_report)(effort, 0, 0, True)._replace(status=float(status))
