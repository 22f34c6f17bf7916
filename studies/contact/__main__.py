"""`python -m studies.contact`: filter and thresholds, ledges, and the constrained form."""

import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated

import typer
from dask.system import CPU_COUNT
from rich.progress import Progress as Bar
from rich.progress import TaskID

from drake_linefoot.lab.results.tables import wide_console
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.sweep.provenance import made_with
from drake_linefoot.robot.humanoid import load_humanoid
from studies.common.command import SWEEPS, Processes, Quick, Sweeps, run
from studies.common.files import prepare, write_json, write_picture, write_text
from studies.common.pool import carry_out, progress_bar
from studies.contact.constrained import compare
from studies.contact.contact_page import contact_page, draw_grid
from studies.contact.ledges import PHASES, cross, crossings, summarize
from studies.contact.replayed import Observed, observe
from studies.contact.thresholds import GAMMAS, TOUCHES, choice, grid
from studies.contact.walks import Walk, recorded_walk, scenarios

JSON, PAGE, PICTURE = "contact.json", "contact.md", "contact.png"


@dataclass(frozen=True)
class Effort:
    """How much is done."""

    walks: int  # of each kind
    duration: float | None  # of each [s]; None for all of it
    phases: int  # places of the ledge
    gammas: tuple[float, ...]  # of the grid
    touches: tuple[float, ...]  # of the grid


FULL = Effort(4, None, PHASES, GAMMAS, TOUCHES)
QUICK = Effort(1, 2.0, 1, (0.0, 0.7), (30.0, 50.0))


def contact(
    files: Sweeps = None,
    out: Annotated[Path, typer.Option(help="Folder of the page.")] = Path("docs/robustness"),
    quick: Quick = False,
    workers: Processes = None,
) -> None:
    """Study the contact estimator: filter, thresholds, steps in the ground, constrained form."""
    words = ["python -m studies.contact", *map(str, files or ()), *(["--quick"] if quick else [])]
    effort = QUICK if quick else FULL
    default = Scenario().estimator
    chosen = scenarios(files or SWEEPS, effort.walks, effort.duration)
    prepare(out)
    with progress_bar(wide_console()) as bar:
        over = crossings(effort.phases)
        task = bar.add_task("ledges", total=len(over) + 2 * len(chosen) + 1)
        rows = carry_out(cross, over, lambda *_: bar.advance(task), workers or CPU_COUNT)
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
        "walks": [
            {"kind": w.kind, "index": w.index, "until_s": float(w.run.time[w.end - 1])}
            for w, _ in walks
        ],
        "command": " ".join(words),
        "made_with": made_with(),
    }
    write_picture(out / PICTURE, draw_grid(data))
    write_json(out / JSON, data, indent=1)
    write_text(out / PAGE, contact_page(data, PICTURE))
    typer.echo(str(out / PAGE))


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


if __name__ == "__main__":
    sys.exit(run(contact, "contact"))
