"""Solvers of the MPC's quadratic program: OSQP and Clarabel through Drake, others directly.

Every solver gets the same program, ready in the form that it takes, and starts cold. Putting the
program into that form is not timed, setting up the solver is: the program is another one in every
update, and often of another size. A solver is timed at its loosest setting that is accurate enough.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np

from drake_linefoot.contact.cone_program import ConeProgram
from drake_linefoot.math.active_set import solve_few_active
from drake_linefoot.mpc.condensed_qp import CondensedQp
from drake_linefoot.mpc.parameters import ACTIVE_SET, MpcParameters
from drake_linefoot.mpc.solve import RHO
from studies.common.types import Array

Run = Callable[[], Array | None]
Prepare = Callable[[CondensedQp, float], Run]

MAX_ITERATIONS = 100_000
REFERENCE_TOLERANCE = 1e-12  # [-]
EXACT = MpcParameters.tolerance  # [-] by which an active set may miss a row
LARGEST_ERROR = 1.0  # [N] that a solver may leave in the first wrench
TOLERANCES = tuple(10.0**-k for k in range(1, 12))  # loosest first


@dataclass(frozen=True)
class Solver:
    """A solver and how it is called."""

    package: str  # to import; also the name of its distribution
    how: str  # in words
    prepare: Prepare  # of program and tolerance; returns what solves it (None: not solved)
    tolerances: tuple[float, ...] = TOLERANCES  # to try, loosest first


def _through_drake(name: str) -> Prepare:
    programs: dict[float, ConeProgram] = {}  # built once per tolerance, as the MPC's is

    def prepare(qp: CondensedQp, tolerance: float) -> Run:
        program = programs.setdefault(tolerance, ConeProgram(name, tolerance, MAX_ITERATIONS, RHO))
        zero = np.zeros(qp.W.shape[:2])

        def run() -> Array | None:
            solution = program.solve(qp.H, qp.g, qp.W, zero)
            return solution.z if solution.success else None

        return run

    return prepare


def _active_set(qp: CondensedQp, tolerance: float) -> Run:
    """Prepare what the MPC calls by that name."""
    A = qp.rows()
    room = np.zeros(len(A))

    def run() -> Array | None:
        z, found = solve_few_active(qp.H, qp.g, A, room, tolerance)
        return z if found else None

    return run


def _daqp(qp: CondensedQp, tolerance: float) -> Run:
    daqp: Any = import_module("daqp")
    H, g, A = np.ascontiguousarray(qp.H), np.ascontiguousarray(qp.g), qp.rows()
    upper = np.zeros(len(A))
    lower, sense = np.full(len(A), -1e30), np.zeros(len(A), dtype=np.int32)
    settings = {"primal_tol": tolerance, "dual_tol": tolerance, "iter_limit": MAX_ITERATIONS}

    def run() -> Array | None:
        z, _, flag, _ = daqp.solve(H, g, A, upper, lower, sense, **settings)
        return np.asarray(z) if flag == 1 else None

    return run


def _piqp(qp: CondensedQp, tolerance: float) -> Run:
    piqp: Any = import_module("piqp")
    H, G = np.asfortranarray(qp.H), np.asfortranarray(qp.rows())
    upper = np.zeros(len(G))

    def run() -> Array | None:
        solver = piqp.DenseSolver()
        solver.settings.eps_abs = solver.settings.eps_rel = tolerance
        solver.settings.eps_duality_gap_abs = solver.settings.eps_duality_gap_rel = tolerance
        solver.setup(H, qp.g, G=G, h_u=upper)
        solved = solver.solve() == piqp.PIQP_SOLVED
        return np.array(solver.result.x) if solved else None

    return run


def _proxqp(qp: CondensedQp, tolerance: float) -> Run:
    proxqp: Any = import_module("proxsuite").proxqp  # its submodules are no modules
    C = qp.rows()
    lower, upper = np.full(len(C), -1e20), np.zeros(len(C))

    def run() -> Array | None:
        solver = proxqp.dense.QP(len(qp.g), 0, len(C))
        solver.settings.eps_abs = tolerance
        solver.settings.eps_rel = 0.0
        solver.settings.max_iter = MAX_ITERATIONS
        solver.init(qp.H, qp.g, None, None, C, lower, upper)
        solver.solve()
        solved = solver.results.info.status == proxqp.PROXQP_SOLVED
        return np.array(solver.results.x) if solved else None

    return run


def _quadprog(qp: CondensedQp, tolerance: float) -> Run:
    """Prepare quadprog, which has no tolerance to set."""
    quadprog: Any = import_module("quadprog")
    H, a = np.array(qp.H), -qp.g
    C = np.ascontiguousarray(-qp.rows().T)
    b = np.zeros(C.shape[1])

    def run() -> Array | None:
        try:
            return np.asarray(quadprog.solve_qp(H, a, C, b)[0])
        except ValueError:  # says that it found no solution
            return None

    return run


SOLVERS = {
    "osqp": Solver("drake", "through Drake's MathematicalProgram", _through_drake("osqp")),
    ACTIVE_SET: Solver("drake_linefoot", "`mpc.solver: active_set`", _active_set, (EXACT,)),
    "clarabel": Solver("drake", "through Drake's MathematicalProgram", _through_drake("clarabel")),
    "daqp": Solver("daqp", "directly", _daqp),
    "piqp": Solver("piqp", "directly, dense", _piqp),
    "proxqp": Solver("proxsuite", "directly, dense", _proxqp),
    "quadprog": Solver("quadprog", "directly; has no tolerance", _quadprog, (0.0,)),
}


def reference_solution(qp: CondensedQp) -> Array | None:
    """Return the solution to compare with: Clarabel at 1e-12, or nothing when it fails.

    At 1e-10 it is still up to 0.5 N away from what the active-set solvers and OSQP agree on.
    """
    return _through_drake("clarabel")(qp, REFERENCE_TOLERANCE)()


@dataclass(frozen=True)
class Target:
    """A program and its solution."""

    qp: CondensedQp  # the program
    z: Array  # its solution in scaled variables, shape (5 n,)


class Setting(NamedTuple):
    """The result of a search for a tolerance."""

    tolerance: float | None  # the loosest that will do; None when none does
    error: float  # largest over all programs [N], there or at the best one; infinite: not solved


def first_wrench_error(target: Target, z: Array | None, half_length: float) -> float:
    """Return the largest error [N] of a solver's `z` in the wrenches of the first interval.

    Torques count as the force at the end of the contact line, `half_length` [m] away, that makes
    them; infinite when the solver failed (`z` is None).
    """
    if z is None or z.shape != target.z.shape or not np.isfinite(z).all():
        return float("inf")
    difference = (target.qp.scale * (z - target.z)).reshape(-1, 5)
    first = np.abs(difference[target.qp.active[:, 0] == 0])
    first[:, 3:] /= half_length
    return float(first.max(initial=0.0))


def loosest(
    prepare: Prepare, targets: Sequence[Target], tolerances: Sequence[float], half_length: float
) -> Setting:
    """Return the loosest tolerance at which every program is solved to `LARGEST_ERROR`.

    `tolerances` are tried in their order, loosest first; `half_length` is the contact line's [m].
    """
    best = float("inf")
    for tolerance in tolerances:
        worst = 0.0
        for target in targets:
            error = first_wrench_error(target, prepare(target.qp, tolerance)(), half_length)
            worst = max(worst, error)
            if not np.isfinite(worst):
                break
        if worst <= LARGEST_ERROR:
            return Setting(tolerance, worst)
        best = min(best, worst)
    return Setting(None, best)
