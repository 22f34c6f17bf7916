"""How times grow: the MPC with knots, horizon and contacts, the controller with joints."""

import cProfile
import pstats
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from drake_linefoot.mpc.models.registry import MODELS
from studies.bench.blocks import MpcUpdate, WbcTick, with_other_horizon
from studies.bench.measures import by_part, exponent, take_turns
from studies.common import models
from studies.common.recorder import MpcProblem, Tick, Walk, spread

KNOTS = (8, 10, 14, 20, 28, 40)
KNOT_STEPS = (0.02, 0.04, 0.08)  # [s] with the scenario's number of knots
GROUPS = 5  # of problems with the same number of wrenches
SHOWN = 8  # functions of a profile
WHOLE = "whole"


def mpc_over_knots(walk: Walk, problems: int, rounds: int) -> dict[str, Any]:
    """Return times of the MPC and its parts over the number of knots, with exponents.

    As below: of so many consecutive `problems` of the walk, in so many `rounds` of turns.
    """
    return growth("knots", KNOTS, _mpc_medians(walk, "knots", KNOTS, problems, rounds))


def mpc_over_models(walk: Walk, problems: int, rounds: int) -> dict[str, Any]:
    """Return times of the MPC and its parts with each model, and the whole's over the ECD's."""
    models = list(MODELS)
    medians = _mpc_medians(walk, "model", models, problems, rounds)
    found, ecd = (
        growth("models", models, medians, fitted=False),
        medians[WHOLE][models.index("ecd")],
    )
    return {**found, "over_ecd": [time / ecd for time in medians[WHOLE]]}


def mpc_over_knot_step(walk: Walk, problems: int, rounds: int) -> dict[str, Any]:
    """Return times of the MPC over the length of its horizon, knots as they are."""
    medians = _mpc_medians(walk, "knot_step", KNOT_STEPS, problems, rounds)
    horizons = [walk.scenario.mpc.knots * step for step in KNOT_STEPS]
    return growth("horizon_s", horizons, {WHOLE: medians[WHOLE]}, fitted=False)  # alike to solve


def growth(
    name: str, sizes: Sequence[Any], medians: Mapping[str, Sequence[float]], fitted: bool = True
) -> dict[str, Any]:
    """Return sizes by their name, the medians [s] in ms, and the exponent of each part."""
    milliseconds = {part: [1e3 * m for m in times] for part, times in medians.items()}
    found: dict[str, Any] = {name: list(sizes), "median_ms": milliseconds}
    if fitted:
        found["exponent"] = {part: exponent(sizes, times) for part, times in medians.items()}
    return found


def mpc_over_contacts(walk: Walk, rounds: int) -> dict[str, Any]:
    """Return times of the MPC over the number of wrenches in its horizon, and the exponent.

    From one foot at a time (one wrench in each interval) to a robot that stands (two).
    """
    groups: dict[int, list[MpcProblem]] = {}
    for problem in walk.problems[1:]:  # the first starts from no plan
        groups.setdefault(int(problem.reference.contact.sum()), []).append(problem)
    counts = spread(sorted(groups), GROUPS)
    update = MpcUpdate(walk.humanoid, walk.scenario)
    batches = {
        str(n): lambda n=n: [update.whole(problem)[0] for problem in groups[n][:5]] for n in counts
    }
    times = take_turns(batches, rounds)
    medians = [float(np.median(times[str(n)])) for n in counts]
    return growth("wrenches", counts, {WHOLE: medians})


def wbc_over_joints(walk: Walk, ticks: Sequence[Tick], rounds: int) -> dict[str, Any]:
    """Return times of the whole-body controller over degrees of freedom, and the exponent.

    Measured on the ticks whose wrench program is solved in the same way on every robot: where the
    cones are touched on one and not on another, there is more to do.
    """
    humanoid = walk.humanoid
    with tempfile.TemporaryDirectory(prefix="linefoot-") as name:
        folder = Path(name)
        variants = {
            "without arms": models.without_arms(humanoid, folder),
            "as it is": humanoid,
            "five more joints": models.with_extra_joints(humanoid, folder),
        }
    wbcs = {name: WbcTick(robot, walk.scenario) for name, robot in variants.items()}
    inputs = {
        name: [
            replace(t, before=replace(t.before, x=models.carried_over(t.before.x, humanoid, robot)))
            for t in ticks
        ]
        for name, robot in variants.items()
    }
    ways = [
        [wbcs[name].status(tick) for name, tick in zip(wbcs, own, strict=True)]
        for own in zip(*inputs.values(), strict=True)
    ]
    alike = [i for i, way in enumerate(ways) if len(set(way)) == 1]

    batches = {
        name: lambda name=name: [wbcs[name](inputs[name][i])[0] for i in alike] for name in wbcs
    }
    times = take_turns(batches, rounds)
    sizes = [robot.nv for robot in variants.values()]
    medians = [float(np.median(times[name])) if alike else 0.0 for name in variants]
    found = growth("degrees_of_freedom", sizes, {WHOLE: medians})
    if not alike:
        found["median_ms"] = {WHOLE: [None] * len(sizes)}
    return {"robots": list(variants), "ticks": len(alike), **found}


def where_time_goes(block: WbcTick | MpcUpdate, inputs: Sequence[Any]) -> list[dict[str, Any]]:
    """Return the functions with the largest own time of a block, and their shares of it.

    The profiler makes Python's calls dearer than they are: shares are for orientation.
    """
    profiler = cProfile.Profile()
    for one in inputs:
        block.set(one)
        profiler.runcall(block.run)
    stats: Any = pstats.Stats(profiler)
    total = sum(entry[2] for entry in stats.stats.values())
    largest = sorted(stats.stats.items(), key=lambda item: -item[1][2])[:SHOWN]
    return [
        {"function": _function(*where), "share": round(entry[2] / total, 3)}
        for where, entry in largest
    ]


def _function(file: str, line: int, name: str) -> str:
    """Return how a function is called in a profile, without folders of this machine."""
    parts = Path(file).parts
    if "drake_linefoot" in parts:
        start = len(parts) - 1 - parts[::-1].index("drake_linefoot")
        return f"{'/'.join(parts[start + 1 :])}: {name}"
    if file == "~":
        return name.split(" at 0x", maxsplit=1)[0]
    return f"{Path(file).name}: {name}"


def _mpc_medians(
    walk: Walk, parameter: str, values: Sequence[Any], problems: int, rounds: int
) -> dict[str, list[float]]:
    """Return median times [s] of the whole update and its parts over a parameter of the MPC."""
    scenarios = [
        replace(walk.scenario, mpc=replace(walk.scenario.mpc, **{parameter: value}))
        for value in values
    ]
    of_walking = walk.walking_problems(len(walk.problems))
    middle = max(len(of_walking) - problems - 1, 0) // 2
    consecutive = of_walking[middle : middle + problems + 1]
    updates = [MpcUpdate(walk.humanoid, scenario) for scenario in scenarios]
    inputs = [with_other_horizon(walk.humanoid, s, consecutive) for s in scenarios]

    def batch(i: int) -> dict[str, list[float]]:
        rows = [updates[i].parts(problem) for problem in inputs[i]]
        whole = [{WHOLE: updates[i].whole(problem)[0]} for problem in inputs[i]]
        return by_part([*rows, *whole], f"{i} ")

    times = take_turns({str(i): partial(batch, i) for i in range(len(scenarios))}, rounds)
    return {
        name: [float(np.median(times[f"{i} {name}"])) for i in range(len(values))]
        for name in (WHOLE, *MpcUpdate.PARTS)
    }
