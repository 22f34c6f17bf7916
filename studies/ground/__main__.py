"""`python -m studies.ground`: stairs, gaps, stones and blocks, over ground that is known.

Every trial that is done is kept at once, one a line; a study that was broken off goes on with
what this code found, or finds the same.
"""

import sys
from pathlib import Path
from typing import Annotated

import typer

from drake_linefoot.errors import InputError
from drake_linefoot.lab.results.page import render
from drake_linefoot.lab.results.tables import number, wide_console
from studies.common import paired
from studies.common.bars import HEAD as BAR_HEAD
from studies.common.bars import bar_rows, bar_table
from studies.common.command import (
    First,
    Fresh,
    PageOut,
    Processes,
    Quick,
    folder_of,
    run,
    words_of,
)
from studies.common.files import write_json, write_text
from studies.common.stamp import stamped
from studies.common.trials import FRESH, TRIALS, Trials, seconds_of
from studies.common.types import Data
from studies.ground.cases import CASES, RUNS, trials
from studies.ground.summary import bars, summed
from studies.ground.trial import Job, limit, lost, probe, tried_or_drawn

PAIRS = 100  # of each group of the sweep
WAYS = (paired.SIMULATORS[0], paired.KNOWN)  # without a map, with one
HEAD = ("", "runs", "done", "speed [m/s]", "torques cut", "over an edge")


def ground(
    out: PageOut = None,
    case: Annotated[list[str] | None, typer.Option(help="Only trials of this case.")] = None,
    runs: Annotated[int, typer.Option(help="Of each case, at most.")] = RUNS,
    pairs: Annotated[
        int, typer.Option(min=0, help="Of each group of the sweep, with and without a map.")
    ] = PAIRS,
    first: First = FRESH,
    quick: Quick = False,
    fresh: Fresh = False,
    workers: Processes = None,
) -> None:
    """Walk over known ground; write page and summary.json."""
    screen = wide_console()
    out = folder_of(out, "ground", quick or bool(case))
    for name in case or ():
        if name not in CASES:
            raise InputError("studies.ground", "--case", name, f"must be one of {list(CASES)}")
    jobs = [
        job
        for job in trials(quick, first)
        if job.index < first + runs and (not case or job.case in case)
    ]
    every = list[Job]((*trials(quick, first), *paired.draws(pairs, WAYS)))
    kept = Trials(out / TRIALS, tried_or_drawn, lost, limit, workers, paired.kind)
    if rows := kept.begun(every, fresh):
        screen.print(f"{len(rows)} trials hold")
    for count, row in kept.carried_out(jobs, rows):
        screen.print(
            f"{count} of {len(jobs)}: {row['key']}: {row['reason'] or 'done'}", markup=False
        )
    judged = [rows[job.key] for job in jobs]
    draws = 0 if quick or case else pairs
    beside = paired.simulated(draws, WAYS, rows, kept, screen, alike=True)
    found, compared = summed(judged), paired.shares(beside)
    told = {"runs": (runs, RUNS), "pairs": (pairs, PAIRS), "first": (first, FRESH)}
    command = words_of("ground", quick, **told)
    made = stamped("ground", seconds_of([*judged, *beside]), None if quick or case else probe)
    summary = {"command": command, **made, "quick": quick, "bars": bars(found, compared)}
    summary |= {"cases": found, "pairs": compared}
    write_json(out / "summary.json", summary)
    write_text(out / "index.md", page_of(summary))
    screen.print(bar_table(summary["bars"]))
    typer.echo(str(out / "index.md"))


def page_of(summary: Data) -> str:
    """Return the page of what `summary.json` holds."""
    return render(
        "index.md.j2",
        Path(__file__).parent,
        summary=summary,
        bars=bar_rows(summary["bars"]),
        bar_head=BAR_HEAD,
        head=HEAD,
        cases=[cells_of(name, one) for name, one in summary["cases"].items()],
        ways=WAYS,
    )


def cells_of(name: str, one: Data) -> list[str]:
    """Return the cells of a case, see `HEAD`."""
    return [
        f"`{name}`",
        str(one["runs"]),
        str(one["done"]),
        number(one["speed"], ".2f"),
        number(one["cut"], ".0f"),
        f"{one['over_edge']} of {one['landings']}",
    ]


if __name__ == "__main__":
    sys.exit(run(ground, "ground"))
