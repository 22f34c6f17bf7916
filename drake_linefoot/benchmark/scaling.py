"""How times grow: the MPC with knots, horizon and contacts, the controller with joints."""

from __future__ import annotations

import cProfile
import pstats
import tempfile
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from drake_linefoot.benchmark import robots
from drake_linefoot.benchmark.blocks import MpcUpdate, WbcTick, with_other_horizon
from drake_linefoot.benchmark.recording import MpcProblem, Tick, Walk, spread
from drake_linefoot.benchmark.statistics import exponent, summarise, take_turns
from drake_linefoot.scenario import Scenario

KNOTS = (8, 10, 14, 20, 28, 40)
KNOT_STEPS = (0.02, 0.04, 0.08)  # [s] with the scenario's number of knots
GROUPS = 5  # of problems with the same number of wrenches
SHOWN = 8  # functions of a profile
WHOLE = "whole"


def mpc_over_knots(walk: Walk, problems: int, rounds: int) -> dict[str, Any]:
    """Return times of the MPC and its parts over the number of knots, with exponents.

    Args:
        walk: recorded.
        problems: consecutive ones at every number of knots.
        rounds: in which all numbers take turns.
    """
    scenarios = [
        replace(walk.scenario, mpc=replace(walk.scenario.mpc, knots=knots)) for knots in KNOTS
    ]
    medians = _mpc_medians(walk, scenarios, problems, rounds)
    names = (WHOLE, *MpcUpdate.PARTS)
    return {
        "knots": list(KNOTS),
        "median_ms": {name: [1e3 * m[name] for m in medians] for name in names},
        "exponent": {name: exponent(KNOTS, [m[name] for m in medians]) for name in names},
    }


def mpc_over_knot_step(walk: Walk, problems: int, rounds: int) -> dict[str, Any]:
    """Return times of the MPC over the length of its horizon, knots as they are."""
    scenarios = [
        replace(walk.scenario, mpc=replace(walk.scenario.mpc, knot_step=step))
        for step in KNOT_STEPS
    ]
    medians = _mpc_medians(walk, scenarios, problems, rounds)
    knots = walk.scenario.mpc.knots
    return {
        "horizon_s": [knots * step for step in KNOT_STEPS],
        "median_ms": {WHOLE: [1e3 * m[WHOLE] for m in medians]},
    }


def mpc_over_contacts(walk: Walk, rounds: int) -> dict[str, Any]:
    """Return times of the MPC over the number of wrenches in its horizon, and the exponent.

    From one foot at a time (one wrench in each interval) to a robot that stands (two).
    """
    groups: dict[int, list[MpcProblem]] = {}
    for problem in walk.problems[1:]:  # the first starts from no plan
        groups.setdefault(int(problem.reference.contact.sum()), []).append(problem)
    counts = spread(sorted(groups), GROUPS)
    update = MpcUpdate(walk.humanoid, walk.scenario)
    few = {count: groups[count][:5] for count in counts}

    def batch(count: int) -> Callable[[], list[float]]:
        return lambda: [update.whole(problem)[0] for problem in few[count]]

    times = take_turns({str(count): batch(count) for count in counts}, rounds)
    medians = [float(np.median(times[str(count)])) for count in counts]
    return {
        "wrenches": counts,
        "median_ms": {WHOLE: [1e3 * m for m in medians]},
        "exponent": {WHOLE: exponent(counts, medians)},
    }


def wbc_over_joints(walk: Walk, ticks: Sequence[Tick], rounds: int) -> dict[str, Any]:
    """Return times of the whole-body controller over degrees of freedom, and the exponent.

    Measured on the ticks whose wrench program is solved in the same way on every robot: where the
    cones are touched on one and not on another, there is more to do.
    """
    humanoid = walk.humanoid
    with tempfile.TemporaryDirectory(prefix="linefoot-") as name:
        folder = Path(name)
        variants = {
            "without arms": robots.without_arms(humanoid, folder),
            "as it is": humanoid,
            "five more joints": robots.with_extra_joints(humanoid, folder),
        }
    wbcs = {name: WbcTick(robot, walk.scenario) for name, robot in variants.items()}
    inputs = {
        name: [
            replace(t, before=replace(t.before, x=robots.carried_over(t.before.x, humanoid, robot)))
            for t in ticks
        ]
        for name, robot in variants.items()
    }
    ways = [
        [wbcs[name].status(tick) for name, tick in zip(wbcs, own, strict=True)]
        for own in zip(*inputs.values(), strict=True)
    ]
    alike = [i for i, way in enumerate(ways) if len(set(way)) == 1]

    def batch(name: str) -> Callable[[], list[float]]:
        return lambda: [wbcs[name](inputs[name][i])[0] for i in alike]

    times = take_turns({name: batch(name) for name in variants}, rounds)
    sizes = [robot.nv for robot in variants.values()]
    medians = [float(np.median(times[name])) if alike else 0.0 for name in variants]
    return {
        "robots": list(variants),
        "ticks": len(alike),
        "degrees_of_freedom": sizes,
        "median_ms": {WHOLE: [1e3 * m if alike else None for m in medians]},
        "exponent": {WHOLE: exponent(sizes, medians)},
    }


class Block(Protocol):
    """A block that is given its inputs first and is run then."""

    def set(self, inputs: Any, /) -> None:
        """Take inputs."""

    def run(self) -> object:
        """Do what is measured."""


def where_time_goes(block: Block, inputs: Iterable[object]) -> list[dict[str, Any]]:
    """Return the functions with the largest own time of a block, and their shares of it.

    The profiler makes Python's calls dearer than they are: shares are for orientation.

    Args:
        block: what is run.
        inputs: one after the other.
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
    walk: Walk, scenarios: Sequence[Scenario], problems: int, rounds: int
) -> list[dict[str, float]]:
    """Return the median time [s] of the whole update and its parts for each scenario."""
    of_walking = walk.walking_problems(len(walk.problems))
    middle = max(len(of_walking) - problems - 1, 0) // 2
    consecutive = of_walking[middle : middle + problems + 1]
    parts: list[dict[str, list[float]]] = [
        {name: [] for name in MpcUpdate.PARTS} for _ in scenarios
    ]

    def batch(index: int) -> Callable[[], list[float]]:
        update = MpcUpdate(walk.humanoid, scenarios[index])
        own = with_other_horizon(walk.humanoid, scenarios[index], consecutive)

        def run() -> list[float]:
            for problem in own:
                for name, time in update.parts(problem).items():
                    parts[index][name].append(time)
            return [update.whole(problem)[0] for problem in own]

        return run

    times = take_turns({str(i): batch(i) for i in range(len(scenarios))}, rounds)
    found = []
    for i, part in enumerate(parts):
        summaries = {name: summarise(values) for name, values in part.items()}
        summaries[WHOLE] = summarise(times[str(i)])
        found.append({name: s.median for name, s in summaries.items() if s is not None})
    return found
