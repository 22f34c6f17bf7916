"""`python -m studies.envelope`: the fastest commands that are walked or run, with each model.

For each model of the MPC, with the same weights, and on each axis a bisection looks for the largest
command that holds without a fall, under every seed, and is tracked: each of forward, left and
turn rate within `SHARE` of its command or `LEAST`. The gait's limits of commands are raised out of
the way; nothing else is changed. What stopped the robot is read from the run that failed at the
smallest command. Results are written after each axis, so that a study that is broken off leaves
what it found.
"""

import time as clock
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from drake_linefoot.lab.pool import Pool
from drake_linefoot.lab.results.fall_indicators import fall_indicators
from drake_linefoot.lab.results.falls import diagnose
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.scenario.load import dump_scenario, parse_scenario
from drake_linefoot.lab.simulation.recording import Run
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from studies.common.bars import Asked, judged
from studies.common.drawing import BLUE, GREEN, GREY, ORANGE, blank, legend
from studies.common.pool import PROCESSES, carry_out
from studies.common.runs import MODELS, paper_scenario
from studies.common.trial import OFTEN, judge_walk, lost_walk, walk
from studies.common.types import Array, Data
from studies.envelope.bisection import Found, largest

SHARE, LEAST = 0.1, 0.05  # [-] and [m/s, rad/s] that a command may be missed by
NAMES = ("forward speed", "sideways speed", "turn rate")
BEFORE = 1.0  # [s] before the onset of a fall in which cut torques count
NAMED = 2  # joints in the table
DURATION, SEEDS = 20.0, (0, 1, 2, 3, 4)
QUICK_DURATION, QUICK_SEEDS = 6.0, (0,)  # [s]
QUICK_COARSER = 2.0  # [-] of the tolerances
QUICK_MODELS = ("ecd", "contact_consistent")
COLOURS = dict(zip(MODELS, (BLUE, ORANGE, GREY, GREEN), strict=True))
JSON, PICTURE = "envelope.json", "envelope.png"
TITLE = "Fastest commands followed without a fall, walking or running"


@dataclass(frozen=True)
class Axis:
    """A ray of commands: `fixed` plus the size times `direction`."""

    title: str  # in words
    direction: tuple[float, float, float]  # of forward, left, turn rate
    fixed: tuple[float, float, float]  # what does not grow, likewise
    start: float  # size that is tried first
    end: float  # largest size that is tried
    tolerance: float  # of the bisection
    aim: float  # size that the controller is to walk

    def command(self, size: float) -> tuple[float, float, float]:
        """Return forward, left [m/s] and turn rate [rad/s]."""
        vx, vy, turn = np.round(np.array(self.fixed) + size * np.array(self.direction), 4).tolist()
        return vx, vy, turn


NONE = (0.0, 0.0, 0.0)
AXES = {
    "forward": Axis("forward [m/s]", (1.0, 0.0, 0.0), NONE, 2.4, 3.2, 0.05, 2.4),
    "backward": Axis("backward [m/s]", (-1.0, 0.0, 0.0), NONE, 0.8, 1.6, 0.05, 1.4),
    "sideways": Axis("sideways [m/s]", (0.0, 1.0, 0.0), NONE, 0.5, 1.0, 0.05, 0.5),
    "turning": Axis("turning in place [rad/s]", (0.0, 0.0, 1.0), NONE, 2.0, 4.0, 0.1, 2.0),
    "forward_and_turning": Axis(
        "turning at 0.8 m/s [rad/s]", (0.0, 0.0, 1.0), (0.8, 0.0, 0.0), 0.8, 2.0, 0.1, 0.8
    ),
    "running_and_turning": Axis(
        "turning in a run of 1.5 m/s [rad/s]", (0.0, 0.0, 1.0), (1.5, 0.0, 0.0), 1.0, 2.0, 0.1, 1.0
    ),
}


def tracked(command: Sequence[float], measured: Sequence[float] | None) -> bool:
    """Return whether a command was followed."""
    return measured is not None and bool(np.all(np.abs(missed(command, measured)) <= 1.0))


def missed(command: Sequence[float], measured: Sequence[float]) -> Array:
    """Return by how much a command was missed, in what is allowed [-], shape (3,)."""
    error: Array = np.subtract(measured, command)
    return error / np.maximum(SHARE * np.abs(command), LEAST)


def unlimited(scenario: Scenario) -> Scenario:
    """Return a scenario whose gait takes every command of the axes."""
    ends = np.abs([axis.command(axis.end) for axis in AXES.values()]).max(axis=0)
    names = ("forward_max", "lateral_max", "turn_max")
    limits = {n: max(float(e), getattr(scenario.gait, n)) for n, e in zip(names, ends, strict=True)}
    return replace(scenario, gait=replace(scenario.gait, **limits))


def try_command(job: tuple[str, tuple[float, float, float]]) -> dict[str, Any]:
    """Walk a scenario (YAML text) with its command; return what was seen, and what stopped it."""
    text, command = job
    scenario = parse_scenario(text)
    run = simulate(build_closed_loop(scenario))
    row = {"seed": scenario.seed, "command": list(command), **judge_walk(run)}
    held = row["upright"] and tracked(command, row["measured"])
    return {**row, "held": held, "stopped_by": "" if held else reason(run, row["measured"])}


def lost_command(job: tuple[str, tuple[float, float, float]], error: str) -> dict[str, Any]:
    """Return what stands for `try_command` of a walk whose process crashed or took too long."""
    text, command = job
    about = {"seed": parse_scenario(text).seed, "command": list(command), "held": False}
    return {**about, **lost_walk(error), "stopped_by": error}


def reason(run: Run, measured: Sequence[float] | None) -> str:
    """Return in words what stopped a walk: how it ended, and what was seen before.

    That is the cause of a fall and what came with it, or what there was in the second half of a
    walk that did not follow its command; the most severe first. `measured` is forward, left [m/s]
    and turn rate [rad/s]; None after a fall.
    """
    if run.fell or measured is None:
        said, found = f"fell at {run.time[-1]:.2f} s: {run.fall_reason}", diagnose(run)
        cause, seen, begin, end = found.cause, found.indicators, found.onset - BEFORE, found.onset
    else:
        last = run.scenario.segments[-1]
        command = [*last.velocity, last.turn_rate]
        worst = int(np.argmax(np.abs(missed(command, measured))))
        said = f"tracking: {NAMES[worst]} off by {measured[worst] - command[worst]:+.2f}"
        if tracked(command, measured):
            said = "legs inside each other"
        cause, begin, end = "", 0.5 * float(run.time[-1]), float(run.time[-1])
        seen = tuple(fall_indicators(run, int(np.searchsorted(run.time, begin)), len(run.time)))
    gravest = sorted(seen, key=lambda s: (s.name != cause, -s.severity))
    words = list(dict.fromkeys(one.name for one in gravest))
    within = (run.time >= begin) & (run.time < end)
    cut = float(np.mean(run.clipped_torques[within] > 0.0)) if within.any() else 0.0
    if cut > OFTEN:
        words.append(f"torques cut in {100.0 * cut:.0f} % of the ticks")
    return said + (f"; before: {', '.join(words[:3])}" if words else "")


def measure(
    models: Sequence[str], axes: Sequence[str], quick: bool, report: Callable[[str], None]
) -> Iterator[Data]:
    """Bisect `axes` of `AXES` with `models`; `quick` is shorter, one seed, coarser.

    `report` is called with every command that was tried, in words.

    Yields:
        After each axis all that is known: `models`, by model and axis what `summary` gives,
        `axes`, that of the paper's own, `bars` of these, and how it was found.
    """
    start = clock.perf_counter()
    duration, seeds = (QUICK_DURATION, QUICK_SEEDS) if quick else (DURATION, SEEDS)
    shipped = paper_scenario(quick=False)
    found: Data = {model: {} for model in models}
    with Pool(PROCESSES) as pool:

        def attempt(
            model: str, name: str, size: float, some: Sequence[int]
        ) -> tuple[bool, list[Any]]:
            base, command = unlimited(paper_scenario(False, model)), AXES[name].command(size)
            walks = [walk(replace(base, seed=seed), command, duration) for seed in some]
            jobs = [(dump_scenario(one), command) for one in walks]
            rows = carry_out(try_command, jobs, lost_command, pool)
            why = next((row["stopped_by"] for row in rows if not row["held"]), "walked")
            report(f"{model}, {name} {size:g}, seeds {list(some)}: {why}")
            return all(row["held"] for row in rows), rows

        for model, name in product(models, axes):
            axis = AXES[name]
            tolerance = axis.tolerance * (QUICK_COARSER if quick else 1.0)
            tried = partial(attempt, model, name)
            best = largest(tried, seeds, axis.start, axis.end, tolerance)
            found[model][name] = summary(axis, best)
            yield {
                "quick": quick,
                "duration": duration,
                "seeds": list(seeds),
                "scenario": dump_scenario(unlimited(shipped)),
                "models": found,
                "axes": (own := found.get(shipped.mpc.model, {})),
                "bars": bars(own),
                "seconds": round(clock.perf_counter() - start),
            }


def summary(axis: Axis, found: Found) -> Data:
    """Return the result of an axis: command, measured value, torques at limits, what stopped it.

    The measured value and the torques are those of the seed that is farthest from the command.
    """
    result: Data = {
        "title": axis.title,
        "aim": axis.aim,
        "size": 0.0,
        "command": None,
        "measured": None,
        "at_limit": {},
        "stopped_by": "nothing up to the largest command that was tried",
        "stopped_at": None,
    }
    if found.best is not None:
        size, rows = found.best
        command = np.array(axis.command(size))
        worst = max(rows, key=lambda row: float(np.abs(np.array(row["measured"]) - command).max()))
        result.update(size=size, command=command.tolist(), measured=worst["measured"])
        result.update(at_limit=worst["at_limit"], runs=rows)
    if found.failed is not None:
        size, rows = found.failed
        bad = next(row for row in rows if not row["held"])
        result.update(stopped_by=bad["stopped_by"], stopped_at=list(axis.command(size)))
        result["failed_run"] = bad
    return result


def bars(axes: Mapping[str, Data]) -> dict[str, Data]:
    """Return what is asked on each of some axes, see `judged`."""
    return {
        name: judged(Asked(one["title"], one["aim"]), one["size"]) for name, one in axes.items()
    }


def draw(data: Data) -> Figure:
    """Draw what was reached on each axis with each model, against what is aimed at."""
    how = f"{data['duration']:g} s, seeds {data['seeds']}"
    figure, (ax,) = blank(f"{TITLE} ({how})", 1, 1, (11.0, 7.0))
    thick = 0.8 / len(data["models"])
    shown = [name for name in AXES if any(name in axes for axes in data["models"].values())]
    for i, (model, axes) in enumerate(data["models"].items()):
        for j, name in enumerate(shown):
            if (one := axes.get(name)) is None:
                continue
            y, named = -j - (i + 0.5) * thick, None if j else MODELS[model]
            ax.barh(y, one["size"] / one["aim"], 0.9 * thick, color=COLOURS[model], label=named)
            stopped = one["stopped_by"].split("; ")[0].split(", ")[0]
            text = f"{one['size']:g}; then {stopped}"
            ax.text(0.01, y, text, va="center", fontsize=7, color="white").set_in_layout(False)
    ax.axvline(1.0, color="black", ls="--")
    titles = [f"{AXES[name].title}, aim {AXES[name].aim:g}" for name in shown]
    ax.set_yticks(-0.4 - np.arange(len(titles)), titles)
    ax.set_ylim(-len(titles) + 0.1, 0.1)
    ax.set_xlabel("largest command walked / aim [-]")
    return legend(figure, ax)


def table(data: Data) -> list[list[str]]:
    """Return what was reached on each axis with each model, header first."""
    head = ["axis", "model", "walked", "aim", "measured x, y, turn"]
    rows = [[*head, "torques at their limits; what stopped a larger command"]]
    for name, (model, axes) in product(AXES, data["models"].items()):
        if (one := axes.get(name)) is None:
            continue
        measured = one["measured"]
        shown = "-" if measured is None else ", ".join(f"{value:.2f}" for value in measured)
        often = list(one["at_limit"].items())[:NAMED]
        limited = ", ".join(f"{joint} {100.0 * share:.0f} %" for joint, share in often) or "none"
        row = [one["title"], MODELS[model], f"{one['size']:g}", f"{one['aim']:g}", shown]
        row.append(f"{limited}; {one['stopped_by']}")
        rows.append([cell.replace("[", "(").replace("]", ")") for cell in row])
    return rows
