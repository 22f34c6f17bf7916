"""`python -m studies.contact`: filter and thresholds, ledges, and the constrained form."""

import sys
from dataclasses import asdict, dataclass
from functools import partial

import typer

from drake_linefoot.lab.pool import Pool
from drake_linefoot.lab.results.tables import wide_console
from drake_linefoot.lab.scenario import Scenario
from studies.common.command import SWEEPS, PageOut, Processes, Quick, Sweeps, folder_of, run
from studies.common.files import write_json, write_picture, write_text
from studies.common.pool import carry_out
from studies.common.stamp import stamped
from studies.common.trials import seconds_of
from studies.contact.constrained import forms
from studies.contact.contact_page import contact_page, draw_grid
from studies.contact.ledges import PHASES, cross, crossings, lost, probe, summarize
from studies.contact.studied import lost as lost_walk
from studies.contact.studied import study
from studies.contact.thresholds import GAMMAS, TOUCHES, choice, choices, grid
from studies.contact.walks import scenarios

JSON, PAGE, PICTURE = "contact.json", "contact.md", "contact.png"


@dataclass(frozen=True)
class Effort:
    """How much is done."""

    walks: int  # of each kind
    duration: float | None  # of each [s]; None for all of it
    phases: int  # places of the ledge
    gammas: tuple[float, ...]  # of the grid
    touches: tuple[float, ...]  # of the grid


FULL = Effort(24, None, PHASES, GAMMAS, TOUCHES)
QUICK = Effort(1, 2.0, 1, (0.0, 0.7), (30.0, 50.0))


def contact(
    files: Sweeps = None,
    out: PageOut = None,
    quick: Quick = False,
    workers: Processes = None,
) -> None:
    """Study the contact estimator: filter, thresholds, steps in the ground, constrained form."""
    words = ["python -m studies.contact", *map(str, files or ()), *(["--quick"] if quick else [])]
    effort = QUICK if quick else FULL
    default = Scenario().estimator
    tried = choices(default, effort.gammas, effort.touches)
    walks = scenarios(files or SWEEPS, effort.walks, effort.duration)
    out = folder_of(out, "robustness", quick)
    screen = wide_console()
    with Pool(workers) as pool:
        rows = carry_out(cross, crossings(effort.phases), lost, pool, screen)
        found = carry_out(partial(study, tried, default), walks, lost_walk, pool, screen)
    seconds = seconds_of(rows) + sum(one.seconds for one in found)
    cells = grid(tried, default, [(one.kind, one.scores) for one in found])
    data = {
        "grid": cells,
        "choice": choice(cells),
        "default": asdict(default),
        "ledges": {"summary": summarize(rows), "walks": rows},
        "forms": forms([(one.kind, one.compared) for one in found]),
        "walks": [{"kind": w.kind, "index": w.number, "until_s": w.until} for w in found],
        "command": " ".join(words),
        **stamped("contact", seconds, None if quick else probe),
    }
    write_picture(out / PICTURE, draw_grid(data))
    write_json(out / JSON, data, indent=1)
    write_text(out / PAGE, contact_page(data, PICTURE))
    typer.echo(str(out / PAGE))


if __name__ == "__main__":
    sys.exit(run(contact, "contact"))
