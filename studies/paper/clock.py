"""The clock of figure 2: the time that both controllers take for recorded states."""

import time
from collections.abc import Callable, Sequence

import numpy as np
from pydrake.solvers import ClarabelSolver, MathematicalProgram, OsqpSolver

from drake_linefoot.centroidal import sample_plan
from drake_linefoot.contact.cone_program import ConeProgram, make_solver
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.robot.dynamics import robot_dynamics
from drake_linefoot.robot.humanoid import load_humanoid
from drake_linefoot.signals import CentroidalPlan, GaitTargets
from drake_linefoot.wbc.parameters import WbcParameters
from drake_linefoot.wbc.priorities import prioritised_acceleration
from drake_linefoot.wbc.wrench_qp import RHO, scaled_program
from studies.common.types import Array, Data
from studies.paper.two_point import LineContacts, PointContacts, recursive_acceleration

RHOS = tuple(float(RHO * 10.0 ** (0.25 * k)) for k in range(-6, 7))  # that are tried
Recorded = tuple[Array, GaitTargets, CentroidalPlan]


class Clock:
    """Times the whole-body controllers with a line and with two points."""

    def __init__(self, scenario: Scenario) -> None:
        """Take the gains and the solver of the scenario; both forms begin with the same rho."""
        p, h = scenario.wbc, load_humanoid(scenario.robot)
        self._parameters, self._humanoid = p, h
        self._context = h.plant.CreateDefaultContext()
        self._contacts = LineContacts(h, p), PointContacts(h, p)
        self._take([RHO] * len(self._contacts))

    def _take(self, rhos: Sequence[float]) -> None:
        p = self._parameters
        self._rhos = rhos
        self._programs = [ConeProgram(p.solver, p.tolerance, p.max_iterations, r) for r in rhos]

    def tune(self, states: Sequence[Recorded]) -> list[Data]:
        """Take for each form the step size of OSQP with which it needs the fewest iterations.

        Args:
            states: state, targets and plan, each as `both` takes them.

        Returns:
            For line and points `rho`, and the mean `iterations` with each of `RHOS`.
        """
        p = self._parameters
        found: list[Data] = []
        for which in range(len(self._contacts)):
            programs = [self._program(which, *state)[0] for state in states]
            means: list[float] = []
            for rho in RHOS:
                own = [solved(p.solver, program, p, rho)[1] for program in programs]
                means.append(float(np.mean(own)))
            found.append({"rho": RHOS[int(np.argmin(means))], "iterations": means})
        self._take([one["rho"] for one in found])
        return found

    def both(
        self, x: Array, targets: GaitTargets, plan: CentroidalPlan, points_first: bool
    ) -> Array:
        """Return the times of the stages for one state [ms] and OSQP's iterations, shape (2, 6).

        The state `x` is of shape (nq + nv,); line and points take turns in going first.
        """
        result = np.empty((2, 6))
        for which in (1, 0) if points_first else (0, 1):
            result[which] = self._one(which, x, targets, plan)
        return result

    def _program(
        self, which: int, x: Array, targets: GaitTargets, plan: CentroidalPlan
    ) -> tuple[tuple[Array, ...], Callable[[bool], float]]:
        """Return the scaled program of one form, and what times all of it [s]."""
        contacts, cones = self._contacts[which], self._programs[which]
        d = robot_dynamics(self._humanoid, self._context, x)
        sample = sample_plan(plan, targets.time)
        sides = [i for i in (0, 1) if targets.contact[i]]
        feet, wrench = contacts.feet(d, sides), sample.wrench[sides]
        slopes = targets.slope[sides]

        def acceleration(recursive: bool) -> Array:
            if recursive:  # six rows for each foot with two points
                tasks = contacts.tasks(d, [foot.rows for foot in feet], targets, sample)
                return recursive_acceleration(d.M, tasks)
            tasks = contacts.tasks(d, [foot.five for foot in feet], targets, sample)
            J, b = (np.concatenate(part) for part in zip(*tasks, strict=True))
            return prioritised_acceleration(d.M, J, b)[0]

        def everything(recursive: bool) -> float:
            started = time.perf_counter()
            program = contacts.program(d, acceleration(recursive), feet, wrench, slopes)
            cones.solve(*scaled_program(program, contacts.units))
            return time.perf_counter() - started

        program = contacts.program(d, acceleration(False), feet, wrench, slopes)
        return scaled_program(program, contacts.units), everything

    def _one(self, which: int, x: Array, targets: GaitTargets, plan: CentroidalPlan) -> Array:
        """Return the times of one controller [ms] and the iterations, shape (6,)."""
        p, cones = self._parameters, self._programs[which]
        ready, everything = self._program(which, x, targets, plan)
        started = time.perf_counter()
        cones.solve(*ready)
        with_drake = time.perf_counter() - started
        rho = self._rhos[which]
        (own, iterations), (other, _) = (
            solved(name, ready, p, rho) for name in (p.solver, "clarabel")
        )
        times = 1e3 * np.array([own, other, with_drake, everything(True), everything(False)])
        return np.append(times, iterations)


def solved(
    name: str, program: Sequence[Array], parameters: WbcParameters, rho: float
) -> tuple[float, int]:
    """Return the time that a solver says it took for a program [s], setup included, and iterations.

    Cold, for a `program` as `scaled` gives it; `rho` is OSQP's step size.
    """
    p = parameters
    solver, options = make_solver(name, p.tolerance, p.max_iterations, rho)
    H, g, W, room = program
    size = W.shape[2]
    prog = MathematicalProgram()
    z = prog.NewContinuousVariables(len(g), "z")
    prog.AddQuadraticCost(H, g, z, is_convex=True)
    for i, (rows, most) in enumerate(zip(W, room, strict=True)):
        low = np.full(len(most), -np.inf)
        prog.AddLinearConstraint(rows, low, most, z[size * i : size * (i + 1)])
    result = solver.Solve(prog, None, options)
    details = result.get_solver_details()
    if result.get_solver_id() == OsqpSolver().solver_id():
        return float(details.run_time), int(details.iter)
    if result.get_solver_id() == ClarabelSolver().solver_id():
        return float(details.solve_time), int(details.iterations)
    raise ValueError(f"{name}: does not say how long it took")
