"""`python -m studies.envelope`: the fastest commands that are walked or run, with each model.

For each model of the MPC, with the same weights, and on each axis a bisection looks for the largest
command that holds without a fall, under every seed, and is tracked: each of forward, left and
turn rate within `SHARE` of its command or `LEAST`. The gait's limits of commands are raised out of
the way; nothing else is changed. What stopped the robot is read from the run that failed at the
smallest command. Every walk is kept when it is done, and results are written after each axis; a
study that was broken off goes on.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from drake_linefoot.lab.scenario.load import dump_scenario
from studies.common.bars import Asked, judged
from studies.common.command import DOCS
from studies.common.drawing import BLUE, GREEN, GREY, ORANGE, blank, legend
from studies.common.pool import PROCESSES
from studies.common.runs import MODELS, paper_scenario
from studies.common.trials import Trials, kept, seconds_of
from studies.common.types import Data
from studies.envelope.bisection import Found, largest
from studies.envelope.walks import AXES, Attempt, Axis, attempted, limit, lost, unlimited

NAMED = 2  # joints in the table
DURATION, SEEDS = 20.0, (0, 1, 2, 3, 4)
QUICK_DURATION, QUICK_SEEDS = 6.0, (0,)  # [s]
QUICK_COARSER = 2.0  # [-] of the tolerances
QUICK_MODELS = ("ecd", "contact_consistent")
COLOURS = dict(zip(MODELS, (BLUE, ORANGE, GREY, GREEN), strict=True))
JSON, PICTURE = "envelope.json", "envelope.png"
DONE = DOCS / "paper" / "envelope.jsonl"  # where walks are kept, one a line
TITLE = "Fastest commands followed without a fall, walking or running"


class Walks:
    """Walks the attempts of a study, each once; what a file has is taken from there."""

    def __init__(self, file: Path, duration: float, fresh: bool) -> None:
        """Begin, or go on with a file; walks last `duration` [s], and `fresh` forgets the file."""
        self.duration = duration
        self.rows: dict[str, Data] = {}  # that were asked for, by key
        self._trials = Trials(file, attempted, lost, limit, PROCESSES)
        there = [Attempt(**row["attempt"]) for row in kept(file).values()]
        self._known = self._trials.begun(there, fresh)

    def __call__(
        self, model: str, axis: str, size: float, seeds: Sequence[int]
    ) -> tuple[bool, list[Data]]:
        """Return whether a size holds with all of some seeds, and the row of each."""
        jobs = [Attempt(model, axis, size, seed, self.duration) for seed in seeds]
        for _ in self._trials.carried_out(jobs, self._known):
            pass
        found = {job.key: self._known[job.key] for job in jobs}
        self.rows |= found
        return all(row["held"] for row in found.values()), list(found.values())


def measure(
    models: Sequence[str],
    axes: Sequence[str],
    quick: bool,
    report: Callable[[str], None],
    walks: Walks,
) -> Iterator[Data]:
    """Bisect `axes` of `AXES` with `models`; `quick` has one seed and is coarser.

    `report` is called with every command that was tried, in words.

    Yields:
        After each axis all that is known: `models`, by model and axis what `summary` gives,
        `axes`, that of the paper's own, `bars` of these, how it was found, and its `seconds`.
    """
    seeds = QUICK_SEEDS if quick else SEEDS
    shipped = paper_scenario(quick=False)
    found: Data = {model: {} for model in models}

    def attempt(model: str, name: str, size: float, some: Sequence[int]) -> tuple[bool, list[Any]]:
        held, rows = walks(model, name, size, some)
        why = next((row["stopped_by"] for row in rows if not row["held"]), "walked")
        report(f"{model}, {name} {size:g}, seeds {list(some)}: {why}")
        return held, rows

    for model, name in product(models, axes):
        axis = AXES[name]
        tolerance = axis.tolerance * (QUICK_COARSER if quick else 1.0)
        tried = partial(attempt, model, name)
        best = largest(tried, seeds, axis.start, axis.end, tolerance)
        found[model][name] = summary(axis, best)
        yield {
            "quick": quick,
            "duration": walks.duration,
            "seeds": list(seeds),
            "scenario": dump_scenario(unlimited(shipped)),
            "models": found,
            "axes": (own := found.get(shipped.mpc.model, {})),
            "bars": bars(own),
            "seconds": seconds_of(walks.rows.values()),
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
