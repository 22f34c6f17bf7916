"""The clock of figure 2: a recorded walk, and the time both controllers take for its states."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pydrake.solvers import ClarabelSolver, MathematicalProgram, OsqpSolver
from pydrake.systems.framework import Context, EventStatus

from drake_linefoot.contact.cone_program import ConeProgram, make_solver
from drake_linefoot.evaluation.figure import Progress
from drake_linefoot.robot.dynamics import GRAVITY, RobotDynamics, robot_dynamics
from drake_linefoot.robot.humanoid import load_humanoid
from drake_linefoot.scenario import Scenario
from drake_linefoot.signals import CentroidalPlan, GaitTargets, PlanSample
from drake_linefoot.simulation.run import FallWatch
from drake_linefoot.wbc.control import WholeBodyControl
from drake_linefoot.wbc.parameters import WbcParameters
from drake_linefoot.wbc.priorities import prioritised_acceleration, recursive_acceleration
from drake_linefoot.wbc.tasks import contact_task
from drake_linefoot.wbc.two_point import TwoPointControl
from drake_linefoot.wbc.wrench_qp import RHO, ReducedProgram
from drake_linefoot.wiring.closed_loop import ClosedLoop, build_closed_loop

Array = NDArray[np.float64]

CHUNK = 0.25  # [s] of simulated time between two reports of progress


@dataclass(frozen=True)
class Tick:
    """What the whole-body controller was given at one tick.

    Attributes:
        x: state, shape (nq + nv,).
        targets: of the gait.
        plan: of the MPC.
    """

    x: Array
    targets: GaitTargets
    plan: CentroidalPlan


class _Tape:
    """Monitor of a simulator that keeps every tick, and ends it at a fall."""

    def __init__(self, loop: ClosedLoop) -> None:
        self.ticks: list[Tick] = []
        self.watch = FallWatch(loop)
        self._loop = loop

    def __call__(self, root: Context) -> EventStatus:
        loop = self._loop
        context = loop.controller.GetMyContextFromRoot(root)
        x = loop.plant.GetPositionsAndVelocities(loop.plant.GetMyContextFromRoot(root))
        targets = loop.controller.GetOutputPort("targets").Eval(context)
        plan = loop.controller.GetOutputPort("plan").Eval(context)
        self.ticks.append(Tick(x, targets, plan))
        return self.watch(root)


def record(scenario: Scenario, progress: Progress) -> tuple[list[Tick], str]:
    """Simulate a scenario; return every tick, and why the robot fell if it did."""
    loop = build_closed_loop(scenario)
    simulator = loop.make_simulator()
    tape = _Tape(loop)
    simulator.set_monitor(tape)
    end = 0.0
    while end < scenario.duration and not tape.watch.reason:
        end = min(end + CHUNK, scenario.duration)
        simulator.AdvanceTo(end)
        progress(end / scenario.duration, f"recording, {end:.1f} of {scenario.duration:.1f} s")
    return tape.ticks, tape.watch.reason


def spread_out(ticks: Sequence[Tick], count: int) -> list[Tick]:
    """Return at most `count` of the ticks, evenly spread over all of them."""
    chosen = np.linspace(0, len(ticks) - 1, min(count, len(ticks))).round().astype(int)
    return [ticks[i] for i in chosen]


class Clock:
    """Times the whole-body controllers with a line and with two points."""

    def __init__(self, scenario: Scenario) -> None:
        """Build both controllers with the gains and the solver of the scenario."""
        p = scenario.wbc
        self._parameters, self._humanoid = p, load_humanoid(scenario.robot)
        self._context = self._humanoid.plant.CreateDefaultContext()
        self._line = WholeBodyControl(self._humanoid, p)
        self._points = TwoPointControl(self._humanoid, p)
        self._programs = [
            ConeProgram(p.solver, p.tolerance, p.max_iterations, RHO) for _ in range(2)
        ]

    def both(self, tick: Tick, points_first: bool) -> Array:
        """Return the times of the stages for one state [ms], shape (2, 5), line and points.

        Args:
            tick: the state and what the controller was given.
            points_first: which controller goes first.
        """
        d = robot_dynamics(self._humanoid, self._context, tick.x)
        sample = tick.plan.sample(tick.targets.time, GRAVITY)
        result = np.empty((2, 5))
        for which in (1, 0) if points_first else (0, 1):
            result[which] = self._one(which, d, tick, sample)
        return result

    def _one(self, which: int, d: RobotDynamics, tick: Tick, sample: PlanSample) -> Array:
        """Return the times of one controller [ms], shape (5,)."""
        control = self._points if which else self._line
        qp, cones = control.wrench_qp, self._programs[which]
        sides = [i for i in (0, 1) if tick.targets.contact[i]]
        d = control.contacts(d, sides)
        wish, damping = sample.wrench[sides], self._parameters.contact_velocity_gain

        def everything(pseudoinverse: bool) -> float:
            started = time.perf_counter()
            tasks = control.tasks(d, tick.targets, sample)
            if pseudoinverse:
                if which:
                    tasks[0] = contact_task(d, sides, damping)  # six rows for each foot
                vdot = recursive_acceleration(d.M, tasks)
            else:
                vdot, _ = prioritised_acceleration(d.M, tasks)
            program = qp.program(d, vdot, sides, wish)
            cones.solve(*program.scaled(qp.units))
            return time.perf_counter() - started

        vdot, _ = prioritised_acceleration(d.M, control.tasks(d, tick.targets, sample))
        program = qp.program(d, vdot, sides, wish)
        scaled = program.scaled(qp.units)
        started = time.perf_counter()
        cones.solve(*scaled)
        with_drake = time.perf_counter() - started
        own = [self._own(name, program, qp.units) for name in (self._parameters.solver, "clarabel")]
        return 1e3 * np.array([*own, with_drake, everything(True), everything(False)])

    def _own(self, name: str, program: ReducedProgram, units: Array) -> float:
        return solver_time(name, program, units, self._parameters)


def solver_time(
    name: str, program: ReducedProgram, units: Array, parameters: WbcParameters
) -> float:
    """Return the time that a solver says it took for a program [s], setup included.

    Args:
        name: "osqp" or "clarabel".
        program: what to solve, cold.
        units: of one foot's unknowns, shape (c,).
        parameters: tolerance and bound on the work.
    """
    p = parameters
    solver, options = make_solver(name, p.tolerance, p.max_iterations, RHO)
    H, g, W, room = program.scaled(units)
    count, _, size = W.shape
    prog = MathematicalProgram()
    z = prog.NewContinuousVariables(count * size, "z")
    prog.AddQuadraticCost(H, g, z, is_convex=True)
    for i in range(count):
        low = np.full(len(room[i]), -np.inf)
        prog.AddLinearConstraint(W[i], low, room[i], z[size * i : size * (i + 1)])
    result = solver.Solve(prog, None, options)
    details = result.get_solver_details()
    if result.get_solver_id() == OsqpSolver().solver_id():
        return float(details.run_time)
    if result.get_solver_id() == ClarabelSolver().solver_id():
        return float(details.solve_time)
    raise ValueError(f"{name}: does not say how long it took")
