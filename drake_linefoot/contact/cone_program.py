"""A quadratic program over contact wrenches, built once per size and then updated.

``min 1/2 z'H z + g'z`` subject to ``W_i z_i <= b_i``, block by block: MPC and whole-body
controller have the same form, with z the (scaled) wrenches of the standing feet.
"""

from dataclasses import dataclass

import numpy as np
from pydrake.solvers import (
    ClarabelSolver,
    MathematicalProgram,
    OsqpSolver,
    SolutionResult,
    SolverInterface,
    SolverOptions,
)
from scipy.linalg.lapack import dpotrf
from scipy.sparse import csc_matrix

from drake_linefoot.contact.solvers import SOLVERS
from drake_linefoot.errors import InputError
from drake_linefoot.math.linear import all_finite
from drake_linefoot.statuses import Solved
from drake_linefoot.types import Array

OUTCOMES = {  # Drake's
    SolutionResult.kSolutionFound: Solved.SOLVER,
    SolutionResult.kIterationLimit: Solved.ITERATION_LIMIT,
    SolutionResult.kInfeasibleConstraints: Solved.INFEASIBLE,
    SolutionResult.kInfeasibleOrUnbounded: Solved.INFEASIBLE,
}
LARGEST_ROW = 1e6  # [-] of an entry; OSQP would have trouble to factorise larger ones


@dataclass(frozen=True)
class ConeSolution:
    """What the solver returned.

    Attributes:
        z: the unknowns, shape (n,); meaningful only when `status` is a success.
        status: how it went.
        iterations: of the solver.
        active: rows that are active, where it says so.
    """

    z: Array
    status: Solved
    iterations: int = 0
    active: int = 0

    @property
    def success(self) -> bool:
        """Whether it was solved to the tolerance that was asked for."""
        return self.status.success


def make_solver(
    name: str, tolerance: float, max_iterations: int, rho: float
) -> tuple[SolverInterface, SolverOptions]:
    """Return a Drake solver by name and its options.

    Args:
        name: "osqp" or "clarabel".
        tolerance: absolute and relative tolerance.
        max_iterations: bound on the work; deterministic, unlike a time limit.
        rho: OSQP's step size; a few times the smallest curvature of the cost converges fastest.

    Raises:
        InputError: no such solver.
    """
    options = SolverOptions()
    if name == "osqp":
        solver: SolverInterface = OsqpSolver()
        values = {
            "polishing": 0,  # prints on stdout when no constraint is active
            "eps_abs": tolerance,
            "eps_rel": tolerance,
            "max_iter": max_iterations,
            "check_termination": 10,  # [iterations], not 25: it takes three or four of these
            "rho": rho,
            "adaptive_rho": 0,  # its rhythm follows wall time: not the same bits each time
            "scaling": 0,  # the program comes in variables of order one
        }
    elif name == "clarabel":
        solver = ClarabelSolver()
        values = {
            "tol_gap_abs": tolerance,
            "tol_gap_rel": tolerance,
            "tol_feas": tolerance,
            "max_iter": min(max_iterations, 200),
        }
    else:
        raise InputError("solver", "", name, f"must be one of {SOLVERS}")
    for key, value in values.items():
        options.SetOption(solver.id(), key, value)
    return solver, options


class ConeProgram:
    """Programs that differ in their blocks' number and shape, each built when first needed."""

    def __init__(self, solver: str, tolerance: float, max_iterations: int, rho: float) -> None:
        """Choose the solver, see `make_solver`.

        Raises:
            InputError: no such solver.
        """
        self._solver, self._options = make_solver(solver, tolerance, max_iterations, rho)
        self._clarabel = solver == "clarabel"
        self._programs: dict[tuple[int, ...], _Program] = {}

    def solve(
        self, H: Array, g: Array, W: Array, b: Array, guess: Array | None = None
    ) -> ConeSolution:
        """Solve the program.

        Args:
            H: symmetric positive definite, shape (n c, n c).
            g: shape (n c,).
            W: one block for each wrench, shape (n, r, c).
            b: right-hand sides, shape (n, r).
            guess: start of the iteration, shape (n c,); not used when not finite.

        Returns:
            The solution; `success` is False for anything but a solution to tolerance.
        """
        if len(W) == 0:
            return ConeSolution(np.zeros(0), Solved.NO_CONTACT)
        if not (all_finite(H.ravel()) and all_finite(g) and all_finite(W.ravel())):
            return ConeSolution(np.zeros(len(g)), Solved.NOT_FINITE)
        if not self._clarabel and _refused_by_osqp(H, W):
            return ConeSolution(np.zeros(len(g)), Solved.ILL_POSED)
        program = self._programs.get(W.shape)
        if program is None:
            program = _Program(*W.shape)
            self._programs[W.shape] = program
        program.update(H, g, W, b)
        result = self._solver.Solve(program.prog, guess, self._options)
        details = result.get_solver_details()
        iterations = int(details.iterations if self._clarabel else details.iter)
        outcome = result.get_solution_result()
        status = OUTCOMES.get(outcome, Solved.FAILED)
        z = result.get_x_val()  # in the order of the program's variables, which is that of z
        # OSQP's "solved inaccurate" (2) is reported as success by Drake.
        inaccurate = not self._clarabel and details.status_val != 1
        if status.success and (inaccurate or not all_finite(z)):
            status = Solved.FAILED
        return ConeSolution(z, status, iterations)


def _refused_by_osqp(H: Array, W: Array) -> bool:
    """Return whether OSQP would refuse a program, which it prints on stdout.

    Its constraints are out of range, or its cost is not convex.
    """
    return bool(np.abs(W).max() > LARGEST_ROW or dpotrf(H, clean=False)[1])


class _Program:
    """A MathematicalProgram with `count` cone blocks, and its bindings."""

    def __init__(self, count: int, rows: int, columns: int) -> None:
        self.prog = MathematicalProgram()
        n = count * columns
        z = self.prog.NewContinuousVariables(n, "z")
        cost = self.prog.AddQuadraticCost(np.eye(n), np.zeros(n), z, is_convex=True)
        self._cost = cost.evaluator()
        # All blocks in one sparse matrix, of which only the numbers change.
        row = np.arange(count * rows).reshape(count, 1, rows)
        indices = np.broadcast_to(row, (count, columns, rows)).ravel()
        starts = rows * np.arange(n + 1)
        self._rows = csc_matrix((np.ones(n * rows), indices, starts), shape=(count * rows, n))
        self._lower = np.full(count * rows, -np.inf)
        zero = np.zeros(count * rows)
        self._cones = self.prog.AddLinearConstraint(self._rows, self._lower, zero, z).evaluator()

    def update(self, H: Array, g: Array, W: Array, b: Array) -> None:
        self._cost.UpdateCoefficients(H, g, is_convex=True)
        self._rows.data[:] = np.swapaxes(W, 1, 2).ravel()
        self._cones.UpdateCoefficients(self._rows, self._lower, b.ravel())
