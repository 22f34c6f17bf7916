"""`linefoot envelope`: the fastest commands that the controller walks.

On each axis a bisection looks for the largest command that is walked without a fall, under every
seed, and tracked: each of forward, left and turn rate within `SHARE` of its command or `LEAST`.
The limits of the gait on commands are raised out of the way; nothing else is changed. What stopped
the robot is read from the run that failed at the smallest command.
"""

from __future__ import annotations

import json
import time as clock
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from drake_linefoot import __version__
from drake_linefoot.errors import OutputError
from drake_linefoot.evaluation import stopping
from drake_linefoot.evaluation.bisection import Found, largest
from drake_linefoot.evaluation.drawing import BLUE, DOTS_PER_INCH, GREY, RED, blank
from drake_linefoot.evaluation.figure import Data
from drake_linefoot.evaluation.files import prepare, write_text
from drake_linefoot.evaluation.runs import paper_scenario
from drake_linefoot.evaluation.trial import judge, simulated, walk, workers
from drake_linefoot.robot.humanoid import load_humanoid
from drake_linefoot.scenario import Scenario
from drake_linefoot.scenario_io import dump_scenario, parse_scenario

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from rich.console import Console

SHARE, LEAST = 0.1, 0.05  # [-] and [m/s, rad/s] that a command may be missed by
DURATION, SEEDS = 20.0, (0, 1, 2, 3, 4)
QUICK_DURATION, QUICK_SEEDS = 6.0, (0,)  # [s]
QUICK_COARSER = 2.0  # [-] of the tolerances
JSON, PICTURE = "envelope.json", "envelope.png"
TITLE = "Fastest commands walked without a fall and tracked"


@dataclass(frozen=True)
class Axis:
    """A ray of commands: `fixed` plus the size times `direction`.

    Attributes:
        title: in words.
        direction: of forward, left, turn rate.
        fixed: what does not grow, likewise.
        start: size that is tried first.
        end: largest size that is tried.
        tolerance: of the bisection.
        aim: size that the controller is to walk.
    """

    title: str
    direction: tuple[float, float, float]
    fixed: tuple[float, float, float]
    start: float
    end: float
    tolerance: float
    aim: float

    def command(self, size: float) -> tuple[float, float, float]:
        """Return forward, left [m/s] and turn rate [rad/s]."""
        vx, vy, turn = (
            round(f + size * d, 4) for f, d in zip(self.fixed, self.direction, strict=True)
        )
        return vx, vy, turn


NONE = (0.0, 0.0, 0.0)
AXES = {
    "forward": Axis("forward [m/s]", (1.0, 0.0, 0.0), NONE, 1.3, 2.5, 0.05, 1.4),
    "backward": Axis("backward [m/s]", (-1.0, 0.0, 0.0), NONE, 0.8, 1.6, 0.05, 0.8),
    "sideways": Axis("sideways [m/s]", (0.0, 1.0, 0.0), NONE, 0.5, 1.0, 0.05, 0.5),
    "turning": Axis("turning in place [rad/s]", (0.0, 0.0, 1.0), NONE, 2.0, 4.0, 0.1, 2.0),
    "forward_and_turning": Axis(
        "turning at 0.8 m/s [rad/s]", (0.0, 0.0, 1.0), (0.8, 0.0, 0.0), 0.8, 2.0, 0.1, 0.8
    ),
}


def tracked(command: tuple[float, float, float], measured: list[float] | None) -> bool:
    """Return whether a command was followed."""
    if measured is None:
        return False
    wanted = np.array(command)
    allowed = np.maximum(SHARE * np.abs(wanted), LEAST)
    return bool(np.all(np.abs(np.array(measured) - wanted) <= allowed))


def unlimited(scenario: Scenario) -> Scenario:
    """Return a scenario whose gait takes every command of the axes."""
    ends = np.abs([axis.command(axis.end) for axis in AXES.values()]).max(axis=0)
    gait = scenario.gait
    forward, lateral, turn = (
        max(float(end), limit)
        for end, limit in zip(
            ends, (gait.forward_max, gait.lateral_max, gait.turn_max), strict=True
        )
    )
    gait = replace(gait, forward_max=forward, lateral_max=lateral, turn_max=turn)
    return replace(scenario, gait=gait)


def try_command(job: tuple[str, tuple[float, float, float]]) -> dict[str, Any]:
    """Walk a scenario (YAML text) with its command; return what was seen, and what stopped it."""
    text, command = job
    scenario = parse_scenario(text)
    run = simulated(scenario)
    row = {"seed": scenario.seed, "command": list(command), **judge(run)}
    held = not run.fell and tracked(command, row["measured"])
    reason = stopping.reason(run, load_humanoid(scenario.robot), command, row["measured"])
    return {**row, "held": held, "stopped_by": "" if held else reason}


def measure(quick: bool, tell: Callable[[str], None]) -> Data:
    """Bisect every axis; `tell` hears of every command that was tried."""
    duration, seeds = (QUICK_DURATION, QUICK_SEEDS) if quick else (DURATION, SEEDS)
    base = unlimited(paper_scenario(quick=False))
    axes: Data = {}
    with workers() as pool:
        for name, axis in AXES.items():

            def attempt(
                size: float, some: Sequence[int], axis: Axis = axis, name: str = name
            ) -> tuple[bool, Any]:
                command = axis.command(size)
                jobs = [
                    (dump_scenario(walk(replace(base, seed=seed), command, duration)), command)
                    for seed in some
                ]
                rows = list(pool.map(try_command, jobs))
                why = next((row["stopped_by"] for row in rows if not row["held"]), "walked")
                tell(f"{name} {size:g}, seeds {list(some)}: {why}")
                return all(row["held"] for row in rows), rows

            tolerance = axis.tolerance * (QUICK_COARSER if quick else 1.0)
            found = largest(attempt, seeds, axis.start, axis.end, tolerance)
            axes[name] = summary(axis, found)
    return {
        "version": __version__,
        "quick": quick,
        "duration": duration,
        "seeds": list(seeds),
        "scenario": dump_scenario(base),
        "axes": axes,
    }


def summary(axis: Axis, found: Found) -> Data:
    """Return the result of an axis: command, measured value, what stopped it.

    The measured value is the one of the seed that is farthest from the command.
    """
    result: Data = {
        "title": axis.title,
        "aim": axis.aim,
        "size": 0.0,
        "command": None,
        "measured": None,
        "stopped_by": "nothing up to the largest command that was tried",
        "stopped_at": None,
    }
    if found.best is not None:
        size, rows = found.best
        command = np.array(axis.command(size))
        worst = max(rows, key=lambda row: float(np.abs(np.array(row["measured"]) - command).max()))
        result.update(size=size, command=command.tolist(), measured=worst["measured"])
        result["runs"] = rows
    if found.failed is not None:
        size, rows = found.failed
        bad = next(row for row in rows if not row["held"])
        result.update(stopped_by=bad["stopped_by"], stopped_at=list(axis.command(size)))
        result["failed_run"] = bad
    return result


def draw(data: Data) -> Figure:
    """Draw what was reached on each axis, against what is aimed at."""
    how = f"{data['duration']:g} s, seeds {data['seeds']}"
    title = f"{TITLE} ({how})"
    figure, (ax,) = blank(title, 1, 1, (11.0, 0.9 * len(data["axes"]) + 1.6))
    for i, one in enumerate(data["axes"].values()):
        y = len(data["axes"]) - 1 - i
        share = one["size"] / one["aim"]
        ax.barh(y, share, 0.5, color=BLUE)
        text = f"{one['size']:g} of {one['aim']:g}. Stopped by: {one['stopped_by']}"
        if one["stopped_at"] is not None:
            at = ", ".join(f"{value:g}" for value in one["stopped_at"])
            text += f" (at {at})"
        ax.text(0.02, y - 0.42, text, fontsize=7, color=GREY if share >= 1.0 else RED)
    ax.axvline(1.0, color=GREY, ls="--")
    ax.set_yticks(range(len(data["axes"])), [a["title"] for a in data["axes"].values()][::-1])
    ax.set_ylim(-0.7, len(data["axes"]) - 0.4)
    ax.set_xlabel("largest command walked / aim [-]")
    return figure


def main_envelope(out: Path, quick: bool, console: Console) -> None:
    """Measure the envelope; write `envelope.json` and `envelope.png`, print a table.

    Args:
        out: folder of the results; made when missing.
        quick: 6 s and one seed instead of 20 s and five, and coarser steps.
        console: where progress and table go.

    Raises:
        OutputError: `out` cannot be written.
    """
    from rich.table import Table

    prepare(out)
    with console.status("measuring") as status:

        def tell(text: str) -> None:
            status.update(text)
            if not console.is_terminal:
                console.print(text, markup=False)

        start = clock.perf_counter()
        data = {**measure(quick, tell), "seconds": round(clock.perf_counter() - start)}
    try:
        write_text(out / JSON, json.dumps(data, indent=2, allow_nan=False) + "\n")
        draw(data).savefig(out / PICTURE, dpi=DOTS_PER_INCH)
    except OSError as error:
        raise OutputError(out, error.strerror or str(error)) from error
    header, *rows = table(data)
    shown = Table(*header)
    for row in rows:
        shown.add_row(*row)
    console.print(shown)


def table(data: Data) -> list[list[str]]:
    """Return what was reached on each axis, header first."""
    rows = [["axis", "largest command", "aim", "measured: forward, left, turn", "stopped by"]]
    for one in data["axes"].values():
        measured = one["measured"]
        shown = "-" if measured is None else ", ".join(f"{value:.2f}" for value in measured)
        row = [one["title"], f"{one['size']:g}", f"{one['aim']:g}", shown, one["stopped_by"]]
        rows.append([cell.replace("[", "(").replace("]", ")") for cell in row])
    return rows
