"""The peers: PlaCo's controller, MuJoCo's plant, and the solvers of the MPC's program."""

from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from drake_linefoot.errors import LinefootError
from drake_linefoot.signals import CentroidalPlan
from studies.bench import placo_peer
from studies.bench.blocks import MpcUpdate
from studies.bench.loops import time_of
from studies.bench.measures import Batch, Results, each, version_of
from studies.bench.mujoco_peer import MujocoStep
from studies.bench.solvers import SOLVERS, Target, first_wrench_error, loosest, reference_solution
from studies.common.recorder import Walk

SHIPPED = "shipped"
SHIPPED_TIME = f"solve_{SHIPPED}"


def placo(
    walk: Walk, count: int, python: Path | None, results: Results, stack: ExitStack
) -> placo_peer.PlacoPeer | None:
    """Start PlaCo on the same ticks; without it there is a note."""
    ticks = walk.walking_ticks(count)
    try:
        peer = placo_peer.PlacoPeer(
            placo_peer.interpreter(python), walk.humanoid, walk.scenario, ticks
        )
    except LinefootError as error:
        results.notes["wbc_tick_over_placo"] = f"{error}. {placo_peer.HOW}"
        return None
    stack.enter_context(peer)
    results.peers["placo"] = {
        "version": peer.version,
        "how": "whole-body QP with line contacts, kinematics included, in its own process",
        "vertical_force_difference_n": peer.force_difference,
    }
    return peer


def mujoco(walk: Walk, results: Results) -> MujocoStep | None:
    """Make the robot in MuJoCo; without it there is a note."""
    try:
        peer = MujocoStep(walk.humanoid, walk.scenario)
    except ImportError as error:
        results.notes["mujoco_step"] = f"{error}; pip install 'drake_linefoot[bench]'"
        return None
    results.peers["mujoco"] = peer.about()
    return peer


def solver_batches(walk: Walk, count: int, results: Results) -> dict[str, Batch]:
    """Return a batch for each solver that is there and accurate enough, at its setting."""
    mpc = MpcUpdate(walk.humanoid, walk.scenario)
    targets, plans = [], []
    for problem in walk.walking_problems(count):
        qp = mpc.program(problem)
        z = reference_solution(qp)
        if z is not None:
            targets.append(Target(qp, z))
            plans.append(problem.plan)
    results.rest["mpc_problems_compared"] = len(targets)
    results.peers[SHIPPED] = _shipped(walk, targets, plans)
    batches: dict[str, Batch] = {}
    for name, solver in SOLVERS.items():
        key = f"solve_{name}"
        about: dict[str, Any] = {"version": version_of(solver.package), "how": solver.how}
        results.peers[name] = about
        try:
            setting = loosest(solver.prepare, targets, solver.tolerances, walk.humanoid.half_length)
        except ImportError as error:
            results.notes[key] = f"{error}; pip install 'drake_linefoot[bench]'"
            continue
        about |= {"tolerance": setting.tolerance, "first_wrench_error_n": setting.error}
        if setting.tolerance is None:
            about["first_wrench_error_n"] = None
            results.notes[key] = f"leaves {setting.error:.3g} N in the first wrench at its best"
            continue
        runs = [solver.prepare(target.qp, setting.tolerance) for target in targets]
        batches[key] = each(time_of, runs)
    return batches


def _shipped(
    walk: Walk, targets: Sequence[Target], plans: Sequence[CentroidalPlan]
) -> dict[str, Any]:
    """Return what is said of the solver as the MPC calls it: its plans' first wrenches."""
    errors = []
    for target, plan in zip(targets, plans, strict=True):
        active = target.qp.active
        z = plan.wrench[active[:, 0], active[:, 1]].ravel() / target.qp.scale
        errors.append(first_wrench_error(target, z, walk.humanoid.half_length))
    parameters = walk.scenario.mpc
    return {
        "version": version_of("drake"),
        "how": f"{parameters.solver} as the MPC calls it, from the plan before",
        "tolerance": parameters.tolerance,
        "first_wrench_error_n": max(errors, default=None),
    }
