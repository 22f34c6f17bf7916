"""`python -m studies.zoo`: which robots walk with nothing typed, and how fast.

Robots of others come from a package, `pip install -r requirements/zoo.txt`; without it the
made-up ones walk. Results are written after each robot, so that a run that is broken off leaves
what it found. Each is tried with feet that are lines and with feet that are surfaces, where it
has soles and ankle rolls for them.
"""

import sys
import time as clock
from pathlib import Path
from typing import Annotated

import typer

from drake_linefoot import __version__
from drake_linefoot.lab.pool import Pool
from drake_linefoot.lab.results.tables import number_table, wide_console
from studies.common.command import Quick, run
from studies.common.files import prepare, write_json, write_text
from studies.common.pool import PROCESSES
from studies.common.types import Data
from studies.zoo.page import HEAD, bars, page_of, row_of
from studies.zoo.robots import MADE_UP, PACKAGE, QUICK, published
from studies.zoo.trials import CONTACTS, FIRST, LAST, Job, met

SEEDS, QUICK_SEEDS, QUICK_PACE = (0, 1, 2), (0,), 0.5
LIMIT = 4.0 * 3600.0  # [s] of a robot
SUMMARY, PAGE = "summary.json", "index.md"


def zoo(
    out: Annotated[Path, typer.Option(help="Folder of the page.")] = Path("docs/zoo"),
    quick: Quick = False,
) -> None:
    """Describe and walk the robots of the zoo; write page, pictures and summary.json."""
    screen = wide_console()
    prepare(out)
    files, package = published()
    if not package:
        screen.print(f"{PACKAGE} is not installed: made-up robots only", markup=False)
    models = dict.fromkeys(QUICK) if quick else {**files, **dict.fromkeys(MADE_UP)}
    how = (QUICK_SEEDS, FIRST, QUICK_PACE, out) if quick else (SEEDS, LAST, 1.0, out)
    start, found, summary = clock.perf_counter(), dict[tuple[str, str], Data](), Data()
    jobs = [Job(name, models[name], contact, *how) for name in models for contact in CONTACTS]
    with Pool(PROCESSES) as pool:
        for done in pool.run(met, jobs, lambda job: LIMIT):
            job: Job = done.job
            found[job.name, job.contact] = done.value or {"refused": done.error}
            robots = {
                name: {contact: found[name, contact] for contact in CONTACTS}
                for name in models
                if all((name, contact) in found for contact in CONTACTS)
            }
            summary = {
                "version": __version__,
                "quick": quick,
                "package": package,
                "seeds": list(how[0]),
                "seconds": round(clock.perf_counter() - start),
                "missing": [name for name in models if name not in robots],
                "bars": bars(robots, len(how[0])),
                "robots": robots,
            }
            write_json(out / SUMMARY, summary)
            write_text(out / PAGE, page_of(summary))
            said = f"{len(found)} of {len(jobs)}: {job.name} as a {job.contact}"
            screen.print(said, markup=False)
    rows = [row_of(name, robot) for name, robot in summary["robots"].items()]
    screen.print(number_table(HEAD, rows))


if __name__ == "__main__":
    sys.exit(run(zoo, "zoo"))
