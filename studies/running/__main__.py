"""`python -m studies.running`: how fast it runs, how well it follows, and what a run survives.

Every trial that is done is kept at once, one a line; a study that was broken off goes on with
what this code found, or finds the same. What walks did before is in a file of `--before`: the
trials that an older version left behind.
"""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from drake_linefoot.lab.results.tables import wide_console
from studies.common.bars import bar_table
from studies.common.command import First, Fresh, PageOut, Processes, Quick, folder_of, run
from studies.common.files import write_json, write_picture, write_text
from studies.common.stamp import Probe, stamped
from studies.common.trials import FRESH, TRIALS, Trials, kept, seconds_of
from studies.common.types import Data
from studies.running.cases import LADDERS, PICTURE, QUICK_RUNS, QUICK_TIME, SEEDS, TIME, VARIANTS
from studies.running.jobs import carry_out, limit_of, missed, wanted
from studies.running.page import page_of
from studies.running.pictures import draw_pushes, draw_run, draw_speeds
from studies.running.probe import probe
from studies.running.summary import bars, figures, groups, rungs

SUMMARY, PAGE = "summary.json", "index.md"
BEFORE = Path("docs/running/before.jsonl")


def running(
    out: PageOut = None,
    before: Annotated[Path, typer.Option(help="Trials of an older version.")] = BEFORE,
    case: Annotated[list[str] | None, typer.Option(help="Only trials of this case.")] = None,
    first: First = FRESH,
    quick: Quick = False,
    fresh: Fresh = False,
    workers: Processes = None,
) -> None:
    """Walk, run, push; write page, pictures and summary.json."""
    screen = wide_console()
    out = folder_of(out, "running", quick or bool(case))
    jobs = wanted(quick, case, first)
    trials = Trials(out / TRIALS, carry_out, missed, limit_of, workers)
    rows = trials.begun(jobs, fresh)
    if before_now := sum(job.key in rows for job in jobs):
        screen.print(f"{before_now} of {len(jobs)} trials were found before")
    for count, row in trials.carried_out(jobs, rows):
        said = "" if row.get("upright", True) else f": {row['reason']}"
        screen.print(f"{count} of {len(jobs)}: {row['key']}{said}", markup=False)
    found = [rows[job.key] for job in jobs]
    some = None if quick or case else probe
    summary = summarize(found, kept(before), quick, some)
    summary["command"] += "" if first == FRESH else f" --first {first}"
    write(out, summary, found)
    screen.print(bar_table(summary["bars"]))
    typer.echo(str(out / PAGE))


def summarize(
    rows: Sequence[Data], before: dict[str, Data], quick: bool, probe: Probe | None = None
) -> Data:
    """Return what `summary.json` holds: `bars`, and what they are made of."""
    return {
        "command": f"python -m studies.running{' --quick' if quick else ''}",
        **stamped("running", seconds_of(rows), probe),
        "quick": quick,
        "trials": len(rows),
        "seeds": QUICK_RUNS if quick else SEEDS,
        "time_s": QUICK_TIME if quick else TIME,
        "bars": bars(figures(rows, before), groups(rows), quick),
        "ladders": {name: rungs(rows, name) for name in LADDERS},
        "variants": {name: rungs(rows, name) for name in VARIANTS},
        "groups": groups(rows),
        "robots": [row for row in rows if row["case"] == "robot"],
    }


def write(out: Path, summary: Data, rows: Sequence[Data]) -> None:
    """Write page, pictures and summary into a folder that exists."""
    drawn = {"Speeds of walk and run": ("speeds.png", draw_speeds(summary["ladders"]))}
    shown = next(
        (row["curves"] for row in rows if row["case"] == PICTURE and "curves" in row), None
    )
    if shown is not None:
        drawn["A run over time"] = ("run.png", draw_run(shown))
    if any(row["case"] == "run_push" for row in rows):
        drawn["Pushes by direction and phase"] = ("pushes.png", draw_pushes(rows))
    for name, figure in drawn.values():
        write_picture(out / name, figure)
    write_json(out / SUMMARY, summary)
    write_text(out / PAGE, page_of(summary, {title: name for title, (name, _) in drawn.items()}))


if __name__ == "__main__":
    sys.exit(run(running, "running"))
