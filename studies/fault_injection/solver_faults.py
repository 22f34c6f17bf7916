"""Numbers that are none, algebra and solvers that fail, somewhere in a walk, for a while.

Each is a counted failure that is walked through, or a fall with a reason; what was simulated is
written in both cases.
"""

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import is_dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from drake_linefoot.contact.cone_program import ConeProgram
from drake_linefoot.errors import LinefootError
from drake_linefoot.estimation import contact_estimator
from drake_linefoot.gait import gait_planner
from drake_linefoot.lab.results.judge import judge
from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.scenario.load import load_scenario
from drake_linefoot.lab.simulation.recording import LOG, Run
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop, warm_up
from drake_linefoot.layout import Layout
from drake_linefoot.mpc import solve
from drake_linefoot.mpc.parameters import ACTIVE_SET
from drake_linefoot.mpc.reference import ReferenceGenerator
from drake_linefoot.robot import state_dynamics
from drake_linefoot.robot.humanoid import load_humanoid
from drake_linefoot.signals import layouts
from drake_linefoot.statuses import Solved
from drake_linefoot.wbc import control
from drake_linefoot.wbc.control import WholeBodyControl
from studies.fault_injection.tally import Tally

SEGMENTS = [Segment("stand", 0.05), Segment("step", 0.35, True, [0.2, 0.0])]
TICKS, UPDATES = (5, 330), (2, 15)  # calls at one of which a fault begins, of 400 and 20
LASTS = (1, 8)  # calls

Spoil = Callable[[Any], Any]


class Fault(NamedTuple):
    """What goes wrong."""

    name: str
    owner: Any
    function: str
    spoil: Spoil  # makes of what the function returns what it returns instead
    calls: tuple[int, int] = TICKS
    counted: str = ""  # the channel that must count it
    solver: str = "osqp"  # of the MPC


def spoilt(value: float, *names: str) -> Spoil:
    """Return what fills attributes with a number."""

    def spoil(result: Any) -> Any:
        new = {name: np.full_like(getattr(result, name), value) for name in names}
        change = replace if is_dataclass(result) else type(result)._replace
        return change(result, **new)

    return spoil


@cache
def _layouts() -> dict[str, Layout[Any]]:
    """Return those of the robot that walks, once it does."""
    return layouts(load_humanoid("mit_humanoid").sizes)


def spoilt_part(value: float, signal: str, *names: str) -> Spoil:
    """Return what fills parts of a signal, as it travels, with a number."""

    def spoil(result: Any) -> Any:
        layout, new = _layouts()[signal], result.copy()
        for name in names:
            new[layout.place(name)] = value
        return new

    return spoil


def raising(error: Exception) -> Spoil:
    """Return what raises an error."""

    def spoil(result: Any) -> Any:
        raise error

    return spoil


def _unsolved(solution: Any) -> Any:
    """Return what a solver says that found nothing."""
    return replace(solution, z=np.full_like(solution.z, np.nan), status=Solved.FAILED)


def _given_up(result: Any) -> Any:
    """Return what an active-set method says that found nothing."""
    *numbers, found = result
    return (*numbers, False) if isinstance(found, bool) else result


def _left_to_solver(result: Any) -> Any:
    """Return a tick's result of which the quick method did not finish."""
    (dropped, active, able, _), program = result
    return (dropped, active, able, False), program


def _not_positive(result: Any) -> Any:
    place, new = _layouts()["dynamics"].place("M"), result.copy()
    new[place] *= -1.0
    return new


def _nothing(result: Any) -> Any:
    return np.full_like(result, np.nan)


NOT_POSITIVE = RuntimeError("The mass matrix is not positive-definite.")
DIVERGED = RuntimeError("MultibodyPlant's contact solver failed to converge.")
SINGULAR = np.linalg.LinAlgError("Singular matrix")
NAN, INF = float("nan"), float("inf")
MPC, WBC = "mpc_failures", "wbc_success"
DYNAMICS, TARGETS = "dynamics_vector", "present_targets"
FAULTS = (
    Fault("torque NaN", WholeBodyControl, "compute", spoilt_part(NAN, "report", "torque")),
    Fault("torque infinite", WholeBodyControl, "compute", spoilt_part(INF, "report", "torque")),
    Fault("torque 1e9 N m", WholeBodyControl, "compute", spoilt_part(1e9, "report", "torque")),
    Fault("acceleration NaN", WholeBodyControl, "compute", spoilt_part(NAN, "report", "vdot")),
    Fault("LinAlgError in the WBC", WholeBodyControl, "compute", raising(SINGULAR)),
    Fault("mass matrix refused", WholeBodyControl, "compute", raising(NOT_POSITIVE)),
    Fault("contact solver diverged", WholeBodyControl, "compute", raising(DIVERGED)),
    Fault("plan's wrench NaN", solve.MpcSolver, "solve", spoilt(NAN, "wrench"), UPDATES),
    Fault("plan's states NaN", solve.MpcSolver, "solve", spoilt(NAN, "states"), UPDATES),
    Fault("plan's states infinite", solve.MpcSolver, "solve", spoilt(INF, "states"), UPDATES),
    Fault("LinAlgError in the MPC", solve.MpcSolver, "solve", raising(SINGULAR), UPDATES),
    Fault("Hessian NaN", solve, "build_qp", spoilt(NAN, "H"), UPDATES, MPC),
    Fault("Hessian infinite", solve, "build_qp", spoilt(INF, "H"), UPDATES, MPC),
    Fault("Hessian 0", solve, "build_qp", spoilt(0.0, "H"), UPDATES),
    Fault("gradient NaN", solve, "build_qp", spoilt(NAN, "g"), UPDATES, MPC),
    Fault("cones NaN", solve, "build_qp", spoilt(NAN, "W"), UPDATES, MPC),
    Fault("Hessian NaN, active set", solve, "build_qp", spoilt(NAN, "H"), UPDATES, MPC, ACTIVE_SET),
    Fault("OSQP fails", ConeProgram, "solve", _unsolved, UPDATES, MPC),
    Fault("active set fails", solve, "solve_few_active", _given_up, UPDATES, "", ACTIVE_SET),
    Fault("WBC left to OSQP", control, "control_tick", _left_to_solver),
    Fault(
        "reference NaN", ReferenceGenerator, "vector", spoilt_part(NAN, "reference", "r"), UPDATES
    ),
    Fault("mass matrix NaN", state_dynamics, DYNAMICS, spoilt_part(NAN, "dynamics", "M")),
    Fault("mass matrix singular", state_dynamics, DYNAMICS, spoilt_part(0.0, "dynamics", "M")),
    Fault("mass matrix negative", state_dynamics, DYNAMICS, _not_positive),
    Fault("Jacobian NaN", state_dynamics, DYNAMICS, spoilt_part(NAN, "dynamics", "J")),
    Fault("bias NaN", state_dynamics, DYNAMICS, spoilt_part(NAN, "dynamics", "Cv")),
    Fault("velocity NaN", state_dynamics, DYNAMICS, spoilt_part(NAN, "dynamics", "v")),
    Fault("contact estimate NaN", contact_estimator, "next_estimate", _nothing),
    Fault(
        "targets' yaw NaN",
        gait_planner,
        "present_targets",
        spoilt_part(NAN, "targets", "yaw", "slope"),
    ),
)


@contextmanager
def breaking(fault: Fault, first: int, lasts: int) -> Iterator[list[int]]:
    """Break a function inside the `with` block, from its call `first` on for so many calls.

    Gives a list of the calls that were broken.
    """
    function, calls, broken = getattr(fault.owner, fault.function), [0], []

    def call(*args: Any, **options: Any) -> Any:
        calls[0] += 1
        result = function(*args, **options)
        if not first <= calls[0] < first + lasts:
            return result
        broken.append(calls[0])
        return fault.spoil(result)

    setattr(fault.owner, fault.function, call)
    try:
        yield broken
    finally:
        setattr(fault.owner, fault.function, function)


def solver_faults(count: int, seed: int, folder: Path) -> Tally:
    """Walk with one fault each, `count` times, each begun and ended at random."""
    warm_up()  # now: the walk that compiles would meet the fault, and break off with it
    tally, walk = Tally("faults of solvers and numbers"), load_scenario("walk")
    for number in range(seed, seed + count):
        fault = FAULTS[number % len(FAULTS)]
        rng = np.random.default_rng(number)
        scenario = replace(walk, segments=SEGMENTS, mpc=replace(walk.mpc, solver=fault.solver))
        first, lasts = int(rng.integers(*fault.calls)), int(rng.integers(*LASTS, endpoint=True))
        with breaking(fault, first, lasts) as broken:
            end, problem = _walked(scenario, fault, broken, folder / LOG)
        where = f"{number}, {fault.name} from call {first} on, {lasts} times"
        tally.count(end, problem and f"{where}: {problem}")
    return tally


def _walked(scenario: Scenario, fault: Fault, broken: list[int], log: Path) -> tuple[str, str]:
    """Return how a run ended, and what was wrong about that."""
    try:
        run = simulate(build_closed_loop(scenario))
        run.save(log)
        json.dumps(judge(run), allow_nan=False)
        again = Run.load(log)
    except (Exception, SystemExit) as error:
        expected = isinstance(error, LinefootError)
        return "broke off", f"{'' if expected else 'unforeseen '}{type(error).__name__}: {error}"
    if not broken:
        return "not reached", "never broken"
    if not (np.array_equal(again.q, run.q) and again.fall_reason == run.fall_reason):
        return "changed", "the log is not the run"
    if run.fell:
        return "fell with its reason", "" if run.fall_reason else "without a reason"
    counts = {MPC: float(run.mpc_failures[-1]), WBC: float(np.sum(1.0 - run.wbc_success))}
    counted = counts.get(fault.counted, len(broken))
    wrong = "" if counted == len(broken) else f"{counted:g} counted of {len(broken)}"
    return "counted and walked through" if fault.counted else "walked through", wrong
