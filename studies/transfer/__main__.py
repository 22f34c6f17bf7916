"""The same walks in MuJoCo and in Drake: `python -m studies.transfer` writes docs/transfer/."""

import sys
from typing import Annotated

import typer
from rich.console import Console

from drake_linefoot.lab.pool import Pool
from drake_linefoot.lab.scenario.load import dump_scenario
from studies.common import paired
from studies.common.command import Fresh, PageOut, Processes, Quick, folder_of, run
from studies.common.files import write_json, write_text
from studies.common.pool import carry_out
from studies.common.stamp import cpu_seconds, stamped
from studies.common.trials import TRIALS, seconds_of
from studies.transfer import robots
from studies.transfer.cases import (
    CASES,
    LENGTH,
    PLANTS,
    RUNS,
    SHORT,
    lost,
    probe,
    scenario_of,
    walked,
)
from studies.transfer.page import BESIDE, MOST, bars_of, page_of


def transfer(
    out: PageOut = None,
    runs: Annotated[
        int,
        typer.Option(
            min=1,
            help=f"Of each group of the sweep; in MuJoCo's own contacts {MOST[paired.OWN]}, "
            f"with late plans {MOST[paired.LATE]} at most.",
        ),
    ] = RUNS,
    quick: Quick = False,
    fresh: Fresh = False,
    workers: Processes = None,
) -> None:
    """Walk each case in each plant, and the sweep of robustness in both; write page and numbers."""
    out = folder_of(out, "transfer", quick)
    screen, length = Console(), SHORT if quick else LENGTH
    trials, runs = paired.trials_in(out / TRIALS, workers), 1 if quick else runs
    most = {key: min(runs, MOST.get(key, runs)) for key in BESIDE}
    every = [draw for key, ways in BESIDE.items() for draw in paired.draws(most[key], ways)]
    made = trials.begun(every, fresh)
    beside = {
        key: paired.shares(paired.simulated(most[key], ways, made, trials, screen))
        for key, ways in BESIDE.items()
    }
    jobs = [
        (case, plant, dump_scenario(scenario_of(case, plant, length)))
        for case in CASES
        for plant in PLANTS
    ]
    with Pool(1, most=len(jobs)) as pool:  # so that CPU times are those of a process by itself
        rows = carry_out(walked, jobs, lost, pool, screen)
    with Pool(workers) as pool:
        others = carry_out(robots.walked, robots.robots(quick), robots.missed, pool, screen)
    seconds = seconds_of(made.values()) + cpu_seconds()
    told = stamped("transfer", seconds, None if quick else probe)
    bars = bars_of(rows, beside["pairs"], others)
    summary = {**told, "bars": bars, "runs": rows, **beside, "robots": others}
    write_json(out / "summary.json", summary)
    write_text(out / "index.md", page_of(summary))


if __name__ == "__main__":
    sys.exit(run(transfer, "transfer"))
