"""`python -m studies.zoo`: which robots walk with nothing typed, and how fast.

Robots of others come from a package, `pip install -r requirements/zoo.txt`; without it the
made-up ones walk. Each is tried with feet that are lines and with feet that are surfaces, where it
has soles and ankle rolls for them. Results are written after each; a run that was broken off goes
on with what the same version found, unless it is told to begin anew.
"""

import json
import sys
import time as clock
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Annotated

import typer

from drake_linefoot.lab.pool import Pool
from drake_linefoot.lab.results.tables import number_table, wide_console
from studies.common.command import PageOut, Quick, folder_of, run
from studies.common.files import write_json, write_text
from studies.common.pool import PROCESSES
from studies.common.stamp import made_by, stamped
from studies.common.trials import FRESH
from studies.common.types import Data
from studies.zoo.disturbed import DIRECTIONS
from studies.zoo.page import HEAD, bars, page_of, row_of
from studies.zoo.robots import MADE_UP, PACKAGE, QUICK, published
from studies.zoo.trials import CONTACTS, FIRST, LAST, Job, met, probe

SEEDS: Sequence[int] = range(FRESH, FRESH + 3)
QUICK_SEEDS, QUICK_PACE = (0,), 0.5
LIMIT = 4.0 * 3600.0  # [s] of a robot
SUMMARY, PAGE = "summary.json", "index.md"
FOUND = "found_in_part"  # entry of the summary: of robots that did not walk both ways yet


def zoo(
    out: PageOut = None,
    quick: Quick = False,
    anew: Annotated[bool, typer.Option("--anew", help="Do not go on with what is there.")] = False,
) -> None:
    """Describe and walk the robots of the zoo; write page, pictures and summary.json."""
    screen = wide_console()
    out = folder_of(out, "zoo", quick)
    files, package = published()
    if not package:
        screen.print(f"{PACKAGE} is not installed: made-up robots only", markup=False)
    models = dict.fromkeys(QUICK) if quick else {**files, **dict.fromkeys(MADE_UP)}
    how = (SEEDS, LAST, 1.0, DIRECTIONS)
    if quick:
        how = (QUICK_SEEDS, FIRST, QUICK_PACE, DIRECTIONS[:1])
    about: Data = {
        "made_with": made_by("zoo"),
        "quick": quick,
        "package": package,
        "seeds": list(how[0]),
    }
    start, file = clock.perf_counter(), out / SUMMARY
    before = {} if anew else found_before(file, about)
    found, spent = before.get(FOUND, dict[str, Data]()), before.get("seconds", 0)
    seconds = spent
    jobs = [Job(name, models[name], contact, out, *how) for name in models for contact in CONTACTS]
    left = [job for job in jobs if job.contact not in found.get(job.name, {})]
    if len(left) < len(jobs):
        there = len(jobs) - len(left)
        screen.print(f"{there} of {len(jobs)} were found before; --anew walks them again")
    with Pool(PROCESSES) as pool:
        for count, done in enumerate(pool.run(met, left, lambda job: LIMIT), 1):
            job: Job = done.job
            found.setdefault(job.name, {})[job.contact] = done.value or {"refused": done.error}
            seconds = spent + round(clock.perf_counter() - start)
            write_json(file, summary := summary_of(about, models, found, seconds))
            write_text(out / PAGE, page_of(summary))
            of_all = len(jobs) - len(left) + count
            said = f"{of_all} of {len(jobs)}: {job.name} as a {job.contact}"
            screen.print(said, markup=False)
    summary = summary_of(about, models, found, seconds)
    if not quick and not summary["missing"]:
        write_json(file, summary | stamped("zoo", seconds, probe))
    robots = summary["robots"]
    rows = [row_of(name, robot) for name, robot in robots.items()]
    shown = [i for i, head in enumerate(HEAD) if not head.startswith(("share", "drift"))]
    some = [[row[i] for i in shown] for row in rows]
    screen.print(number_table([HEAD[i] for i in shown], some))


def found_before(file: Path, about: Data) -> Data:
    """Return the summary that a run of the same about left behind; nothing, where there is none."""
    if not file.exists():
        return {}
    summary = json.loads(file.read_text())
    if any(summary.get(key) != value for key, value in about.items()):
        return {}
    return {**summary, FOUND: {**summary["robots"], **summary.get(FOUND, {})}}


def summary_of(about: Data, models: Iterable[str], found: dict[str, Data], seconds: int) -> Data:
    """Return what `summary.json` holds: robots that walked both ways, and those `FOUND` in part."""
    robots = {
        name: {contact: found[name][contact] for contact in CONTACTS}
        for name in models
        if len(found.get(name, {})) == len(CONTACTS)
    }
    return {
        **about,
        "seconds": seconds,
        "missing": [name for name in models if name not in robots],
        "bars": bars(robots, len(about["seeds"])),
        "robots": robots,
        FOUND: {name: each for name, each in found.items() if name not in robots},
    }


if __name__ == "__main__":
    sys.exit(run(zoo, "zoo"))
