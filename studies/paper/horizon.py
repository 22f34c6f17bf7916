"""How far off the torso is along one plan of the MPC, against the full body's kinematics.

Robots walk with the contact-consistent model; from the states in which it plans, every model makes
its plan, and that plan's CoM, momentum and footholds say exactly how the torso turns
(`plan_error`). Arms count as planned. Speeds, times and turn rates are in the size of a robot; the
others are those of `studies.zoo` that can be described and walk on lines, without its package the
made-up ones alone.
"""

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from drake_linefoot.errors import ModelError
from drake_linefoot.lab.new_robot.analysis import analyse
from drake_linefoot.lab.new_robot.folder import write_folder
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.scenario.load import load_scenario
from drake_linefoot.robot.description import LINE, SCENARIO
from drake_linefoot.robot.humanoid import load_humanoid
from drake_linefoot.robot.scaling import units_of
from studies.common import runs
from studies.common.drawing import BLUE, GREEN, ORANGE, array, blank, legend
from studies.common.pool import carry_out
from studies.common.recorder import record
from studies.common.trial import walk
from studies.common.trials import FRESH
from studies.common.types import Array, Data
from studies.paper import statistic
from studies.paper.figure import Claim, compared
from studies.paper.plan_error import MODELS, TIMES, Planners
from studies.zoo.robots import MADE_UP, make, published

TITLE = "How far off the torso is along one plan, against the full body's kinematics"
MIT = "mit_humanoid"
ALIKE = ("other_order", "y_up_feet")  # the MIT Humanoid, written otherwise: no robots to count
COMMANDS = {  # forward, left [m/s], turn rate [rad/s], of the MIT Humanoid
    "0.4 m/s": (0.4, 0.0, 0.0),
    "0.8 m/s": (0.8, 0.0, 0.0),
    "1.2 m/s": (1.2, 0.0, 0.0),
    "turn": (0.4, 0.0, 0.6),
}
DURATION, PLANS = 4.0, 24  # [s] of a walk, and the plans that are taken of it
SEEDS, SEEDS_OF_OTHERS = (FRESH, FRESH + 1, FRESH + 2), (FRESH,)
QUICK_ROBOTS, QUICK_COMMANDS = (MIT, "no_arms"), ("0.4 m/s", "0.8 m/s")
QUICK_SEEDS, QUICK_DURATION, QUICK_PLANS = (0,), 1.5, 4
COLOURS = dict(zip(MODELS, (GREEN, BLUE, ORANGE), strict=True))
PAIRS = {  # of models, and how a claim begins
    (
        "contact_consistent",
        "ecd",
    ): "The contact-consistent model plans the torso nearer than the ECD",
    ("ecd", "srbm"): "The ECD plans the torso nearer than the single rigid body",
}


@dataclass(frozen=True)
class Job:
    """The walks of one robot."""

    robot: str  # `MIT`, as it is shipped, or one of the zoo
    model: Path | None  # its file, of a robot of others
    commands: Sequence[str]  # of `COMMANDS`
    seeds: Sequence[int]
    duration: float  # of a walk [s], of the MIT Humanoid
    plans: int  # of a walk


def compute(quick: bool) -> Data:
    """Walk every robot and compare its plans."""
    files, _ = published()
    models: dict[str, Path | None] = {MIT: None, **dict.fromkeys(MADE_UP), **files}
    jobs = [
        Job(name, model, tuple(COMMANDS), of, DURATION, PLANS)
        for name, model in models.items()
        for of in [SEEDS if name == MIT else SEEDS_OF_OTHERS]
    ]
    if quick:
        how = (QUICK_COMMANDS, QUICK_SEEDS, QUICK_DURATION, QUICK_PLANS)
        jobs = [Job(name, None, *how) for name in QUICK_ROBOTS]
    rows = [row for found in carry_out(tried, jobs, lost) for row in found]
    fallen = [row for row in rows if row["fell"] and row["robot"] == MIT]
    base = runs.paper_scenario(False, MODELS[0])
    return {
        **runs.facts_of_rows(base, jobs[0].seeds, fallen),
        "times": list(TIMES),
        "rows": rows,
        "summary": {
            name: summary_of([row for row in rows if row["robot"] == name])
            for name in dict.fromkeys(row["robot"] for row in rows)
        },
    }


def tried(job: Job) -> list[Data]:
    """Walk a robot.

    Returns:
        For each walk `robot`, `walk`, `seed`, `fell`, `fall_time` (never known), `fall_reason`: or
        why the robot is no robot, and `errors` [rad]: by model, of each plan at each of `TIMES`.
    """
    with tempfile.TemporaryDirectory() as scratch:
        try:
            base = scenario_of(job.robot, job.model, Path(scratch))
        except ModelError as error:
            return lost(job, f"{error.entry} = {error.value!r}: {error.allowed}")
        size = units_of(load_humanoid(base.robot))
        speed = size["m"] / size["s"]
        found = []
        for name, seed in product(job.commands, job.seeds):
            vx, vy, turn = COMMANDS[name]
            command = (vx * speed, vy * speed, turn / size["s"])
            base.seed = seed
            tape = record(walk(base, command, job.duration * size["s"]))
            row = _row(job.robot, name, seed, tape.fall_reason)
            if not tape.fall_reason:
                planners = Planners(tape.humanoid, tape.scenario.mpc)
                problems = tape.walking_problems(job.plans)
                errors = [planners.errors(problem.x, problem.horizon) for problem in problems]
                row["errors"] = {m: [runs.decimated(e[m], 1) for e in errors] for m in MODELS}
            found.append(row)
        return found


def lost(job: Job, error: str) -> list[Data]:
    """Return what stands for `tried` of a robot that is none, or whose process crashed."""
    return [_row(job.robot, "", job.seeds[0], error)]


def _row(robot: str, name: str, seed: int, reason: str) -> Data:
    row: Data = {"robot": robot, "walk": name, "seed": seed, "fell": bool(reason)}
    return {**row, "fall_time": None, "fall_reason": reason, "errors": dict[str, Any]()}


def scenario_of(robot: str, model: Path | None, folder: Path) -> Scenario:
    """Return the scenario of a robot; what is not `MIT` is described into the folder.

    Raises:
        ModelError: it cannot be described with feet that are lines.
    """
    if robot == MIT:
        return runs.paper_scenario(False, MODELS[0])
    found = analyse(model or make(robot, folder), contact=LINE)
    write_folder(folder / "robot", found)
    return load_scenario(str(folder / "robot" / SCENARIO), {"mpc.model": MODELS[0]})


def summary_of(rows: Sequence[Data]) -> Data:
    """Return the errors of a robot over its walks.

    Args:
        rows: of `tried`.

    Returns:
        `walks` that were walked to their ends, of `tried`; `plans` made of each model; `missing`:
        by model, how many have no number at the last time; `compared`: at how many states all
        models have one then; `median` and `interval` [rad]: by model, over the states where all
        have one, at each of `TIMES`, of 95 %, walks being drawn. None without a number.
    """
    walked = [row for row in rows if not row["fell"]]
    found: Data = {"walks": len(walked), "tried": len(rows)}
    found["plans"] = sum(len(row["errors"][MODELS[0]]) for row in walked)
    empty = np.empty((len(MODELS), 0, len(TIMES)))
    of = [array([row["errors"][model] for model in MODELS]) for row in walked]
    missing = np.isnan(np.concatenate([empty, *of], axis=1))
    found["missing"] = dict(zip(MODELS, missing[..., -1].sum(axis=1).tolist(), strict=True))
    for walk_of in of:
        walk_of[:, np.isnan(walk_of).any(axis=0)] = np.nan
    found["compared"] = int((~missing[..., -1].any(axis=0)).sum())
    found["median"], found["interval"] = {}, {}
    for i, model in enumerate(MODELS):
        unknown = np.full((1, len(TIMES)), np.nan)  # so that there is something
        every = np.concatenate([unknown, *(walk_of[i] for walk_of in of)])
        found["median"][model] = runs.decimated(medians(every), 1)
        ends = intervals([walk_of[i] for walk_of in of]) if len(of) > 1 else None
        found["interval"][model] = None if ends is None else runs.decimated(ends, 1)
    return found


def medians(values: Array) -> Array:
    """Return the medians over the last axis but one, NaN left out; NaN of nothing."""
    ordered = np.sort(values, axis=-2)  # NaN last
    known = np.isfinite(values).sum(axis=-2, keepdims=True)
    ends = [np.take_along_axis(ordered, i, -2) for i in ((known - 1) // 2, known // 2)]
    found: Array = 0.5 * (ends[0] + ends[1])[..., 0, :]
    return found


def intervals(walks: Sequence[Array]) -> Array:
    """Return the interval of the median over plans at each time, walks drawn with replacement.

    `walks` has one array for each, shape (plans, times); the result has (times, 2).
    """
    plans = max(len(of) for of in walks)
    padded = np.array(
        [np.pad(of, ((0, plans - len(of)), (0, 0)), constant_values=np.nan) for of in walks]
    )
    drawn = np.random.default_rng(0).integers(len(walks), size=(runs.RESAMPLES, len(walks)))
    of_draws = medians(padded[drawn].reshape(len(drawn), -1, padded.shape[-1]))
    return np.array([[runs.percentile(row, end) for end in statistic.ENDS] for row in of_draws.T])


def draw(data: Data) -> Figure:
    """Draw the errors of the MIT Humanoid over time, and those of every robot at one time."""
    height = max(4.5, 1.5 + 0.35 * len(data["summary"]))
    figure, (left, right) = blank(TITLE, 1, 2, (13.0, height))
    own, at = data["summary"].get(MIT), array(data["times"])
    for i, (model, colour) in enumerate(COLOURS.items()):
        label = runs.MODELS[model]
        if own is not None:
            median = 1e3 * array(own["median"][model])
            left.plot(at, median, color=colour, marker="o", label=label)
            if own["interval"][model] is not None:
                low, high = 1e3 * array(own["interval"][model]).T
                left.vlines(at + 0.003 * (i - 1), low, high, color=colour, alpha=0.6, lw=3)
        _robots(right, data, model, colour)
    left.set(xlabel="time into the plan [s]", ylabel="error of the torso's orientation [mrad]")
    left.set_yscale("log")
    left.set_title("MIT Humanoid: median over plans, interval over walks", fontsize=10)
    return legend(figure, left)


def _robots(ax: Axes, data: Data, model: str, colour: str) -> None:
    """Draw one model's error of every robot that walked, a row each."""
    walked = [name for name, found in data["summary"].items() if found["walks"]][::-1]
    last = len(data["times"]) - 1
    for y, name in enumerate(walked):
        found = data["summary"][name]
        ax.plot(1e3 * (found["median"][model][last] or np.nan), y, "o", color=colour)
        if found["interval"][model] is not None:
            ax.hlines(y, *(1e3 * array(found["interval"][model][last])), color=colour, alpha=0.5)
    ax.set_yticks(range(len(walked)), [name.replace("_", " ") for name in walked])
    ax.set_xscale("log")
    ax.set_xlabel("error [mrad]")
    ax.set_title(f"every robot, {data['times'][last]:g} s into the plan", fontsize=10)


def table(data: Data) -> list[list[str]]:
    """Return medians and intervals of every robot and model, and what was not walked."""
    head = ["robot", "model", "walks", "plans (without a number), compared"]
    rows = [[*head, *(f"after {t:g} s [mrad]" for t in data["times"])]]
    for name, found in data["summary"].items():
        if not found["walks"]:
            why = next(row["fall_reason"] for row in data["rows"] if row["robot"] == name)
            rows.append([name, "-", f"0 of {found['tried']}", why, *["-"] * len(data["times"])])
            continue
        for model in MODELS:
            walks = f"{found['walks']} of {found['tried']}"
            plans = f"{found['plans']} ({found['missing'][model]}), {found['compared']}"
            ends = found["interval"][model] or [None] * len(data["times"])
            numbers = [
                _shown(value, end) for value, end in zip(found["median"][model], ends, strict=True)
            ]
            rows.append([name, runs.MODELS[model], walks, plans, *numbers])
    return rows


def _shown(value: float | None, interval: list[float | None] | None) -> str:
    if value is None:
        return "-"
    ends = [end for end in interval or () if end is not None]
    first, *rest = (f"{float(f'{1e3 * number:.2g}'):g}" for number in (value, *ends))
    return f"{first} ({' to '.join(rest)})" if rest else first


def claims(data: Data) -> list[Claim]:
    """Return which model's torso is nearest, on the MIT Humanoid and on the others."""
    times = ", ".join(f"{t:g}" for t in data["times"])
    note = (
        f"Medians after {times} s, in the size of the robot, over states from which the plans of "
        "all three can be followed, geometric mean of their ratios; the plan's CoM, momentum and "
        "footholds put through the kinematics of the full body, arms swinging as planned. "
        "Interval by a bootstrap over the {}, {}."
    )
    walks = [(i, summary_of([row])) for i, row in enumerate(data["rows"]) if row["robot"] == MIT]
    summary = data["summary"].items()
    robots = [(name, found) for name, found in summary if name not in (MIT, *ALIKE)]
    result = []
    for (pair, claim), (of, clusters, units) in product(
        PAIRS.items(), (("the MIT Humanoid", walks, "walks"), ("other robots", robots, "robots"))
    ):
        known = [(key, found) for key, found in clusters if found["walks"]]
        points = [
            (key, *({"fell": False, "error": value} for value in values))
            for key, found in known
            for values in zip(*(found["median"][model] for model in pair), strict=True)
        ]
        found = statistic.compared_by_cluster(points, "error")
        words = note.format(units, len(known))
        base = f"the {runs.MODELS[pair[1]]}'s"
        about = (f"{claim} ({of})", found, base, 1.0, "beyond the paper", words)
        result.append(compared(*about, what="error"))
    return result
