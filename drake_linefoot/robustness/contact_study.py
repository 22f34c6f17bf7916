"""`linefoot contact-study`: filter and thresholds, ledges, and the constrained form."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import Progress as Bar
from rich.progress import TaskID

from drake_linefoot.errors import OutputError
from drake_linefoot.evaluation.drawing import DOTS_PER_INCH
from drake_linefoot.evaluation.files import prepare, write_text
from drake_linefoot.evaluation.workers import progress_bar
from drake_linefoot.robot.humanoid import load_humanoid
from drake_linefoot.robustness.constrained import compare
from drake_linefoot.robustness.contact_page import contact_page, draw_grid
from drake_linefoot.robustness.ledges import PHASES, cross_all, crossings, summarize
from drake_linefoot.robustness.replayed import Observed, observe
from drake_linefoot.robustness.thresholds import GAMMAS, TOUCHES, choice, grid
from drake_linefoot.robustness.walks import Walk, recorded_walk, scenarios
from drake_linefoot.scenario import Scenario
from drake_linefoot.sweep.provenance import made_with

JSON, PAGE, PICTURE = "contact.json", "contact.md", "contact.png"


@dataclass(frozen=True)
class Effort:
    """How much is done.

    Attributes:
        walks: of each kind.
        duration: of each [s]; None for all of it.
        phases: places of the ledge.
        gammas, touches: of the grid.
        processes: that simulate at a time.
    """

    walks: int = 4
    duration: float | None = None
    phases: int = PHASES
    gammas: tuple[float, ...] = GAMMAS
    touches: tuple[float, ...] = TOUCHES
    processes: int = 2


QUICK = Effort(walks=1, duration=2.0, phases=1, gammas=(0.0, 0.7), touches=(30.0, 50.0))


def main_contact_study(
    files: Sequence[Path], out: Path, effort: Effort, command: str, console: Console
) -> dict[str, Any]:
    """Carry out the study; write contact.json, contact.md and a picture.

    Args:
        files: sweeps that have the walks.
        out: folder of the page.
        effort: how much is done.
        command: that was given, for the page.
        console: where progress goes.

    Returns:
        What `contact.json` holds: `grid`, `choice`, `ledges` with `summary` and every walk,
        `forms`, `walks`, `command`, `made_with`.

    Raises:
        InputError: a sweep is not usable.
        OutputError: results cannot be written.
    """
    default = Scenario().estimator
    chosen = scenarios(files, effort.walks, effort.duration)
    prepare(out)
    with progress_bar(console) as bar:
        over = crossings(effort.phases)
        task = bar.add_task("ledges", total=len(over) + 2 * len(chosen) + 1)
        rows = cross_all(over, effort.processes, lambda: bar.advance(task))
        bar.update(task, description="walks")
        humanoid = load_humanoid(Scenario().robot)
        walks = _walks(chosen, bar, task)
        bar.update(task, description="grid")
        cells = grid(humanoid, walks, default, effort.gammas, effort.touches)
        bar.update(task, description="constrained form")
        forms = compare(humanoid, walks, default)
    data = {
        "grid": cells,
        "choice": choice(cells),
        "default": asdict(default),
        "ledges": {"summary": summarize(rows), "walks": rows},
        "forms": forms,
        "walks": [{"kind": w.kind, "index": w.index, "until_s": w.end_time} for w, _ in walks],
        "command": command,
        "made_with": made_with(),
    }
    write_study(data, out)
    return data


def write_study(data: dict[str, Any], out: Path) -> None:
    """Write contact.json, contact.md and the picture into an existing folder.

    Raises:
        OutputError: they cannot be written.
    """
    try:
        draw_grid(data).savefig(out / PICTURE, dpi=DOTS_PER_INCH)
        write_text(out / JSON, json.dumps(data, indent=1, allow_nan=False) + "\n")
        write_text(out / PAGE, contact_page(data, PICTURE))
    except OSError as error:
        raise OutputError(out, error.strerror or str(error)) from error


def _walks(
    chosen: Sequence[tuple[Scenario, str, int]], bar: Bar, task: TaskID
) -> list[tuple[Walk, Observed]]:
    """Simulate walks, and compute what the observer needs of them."""
    found = []
    for scenario, kind, index in chosen:
        walk = recorded_walk(scenario, kind, index)
        bar.advance(task)
        found.append((walk, observe(load_humanoid(scenario.robot), walk.run, walk.end)))
        bar.advance(task)
    return found
