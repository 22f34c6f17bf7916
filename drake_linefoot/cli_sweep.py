"""The commands `linefoot sweep`, `robustness` and `contact-study`.

Drake and dask are imported inside them.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from drake_linefoot.cli_inspect import wide_console
from drake_linefoot.cli_options import Count, Processes, Runs, Scheduler, Sweeps
from drake_linefoot.simulation.quiet import quieten_drake

BROKE_OFF = 3


def sweep(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="The sweep, a YAML file.")],
    out: Annotated[
        Path | None, typer.Option(help="Folder of the results; else out/sweep/NAME.")
    ] = None,
    workers: Processes = None,
    scheduler: Scheduler = None,
    replays: Count = 3,
    fresh: Annotated[bool, typer.Option("--fresh", help="Forget what is done.")] = False,
) -> None:
    """Carry out a batch of random runs, or go on with it; write table, report and replays."""
    from drake_linefoot import cli
    from drake_linefoot.sweep.main import Options, main_sweep

    _check_cluster(scheduler, workers)
    quieten_drake()
    options = Options(out, workers, scheduler, fresh, replays)
    console = wide_console()
    report, complete = main_sweep(file, options, console, lambda: cli.open_meshcat(live=False))
    typer.echo(str(report))
    if not complete:
        raise typer.Exit(BROKE_OFF)


def robustness(
    files: Sweeps = None,
    out: Annotated[Path, typer.Option(help="Folder of the page.")] = Path("docs/robustness"),
    sweeps: Annotated[Path, typer.Option(help="Folder of the sweeps' folders.")] = Path(
        "out/sweep"
    ),
    runs: Runs = None,
    workers: Processes = None,
    scheduler: Scheduler = None,
    replays: Count = 0,
    fresh: Annotated[bool, typer.Option("--fresh", help="Forget what is done.")] = False,
) -> None:
    """Carry out the sweeps of robustness, or go on with them; write page and summary.json."""
    from drake_linefoot import cli
    from drake_linefoot.robustness.main import FILES, main_robustness
    from drake_linefoot.sweep.main import Options

    _check_cluster(scheduler, workers)
    quieten_drake()
    console = wide_console()
    words = ["linefoot robustness", *map(str, files or ())]
    if runs is not None:
        words.append(f"--runs {runs}")
    page, complete = main_robustness(
        files or FILES,
        out,
        Options(sweeps, workers, scheduler, fresh, replays, runs),
        " ".join(words),
        console,
        lambda: cli.open_meshcat(live=False),
    )
    typer.echo(str(page))
    if not complete:
        raise typer.Exit(BROKE_OFF)


def contact_study(
    files: Sweeps = None,
    out: Annotated[Path, typer.Option(help="Folder of the page.")] = Path("docs/robustness"),
    quick: Annotated[bool, typer.Option("--quick", help="Fewer, shorter walks.")] = False,
    workers: Processes = None,
) -> None:
    """Study the contact estimator: filter, thresholds, steps in the ground, constrained form."""
    from rich.console import Console

    from drake_linefoot.robustness.contact_study import PAGE, QUICK, Effort, main_contact_study
    from drake_linefoot.robustness.main import FILES
    from drake_linefoot.sweep.cluster import cores

    quieten_drake()
    words = ["linefoot contact-study", *map(str, files or ()), *(["--quick"] if quick else [])]
    effort = replace(QUICK if quick else Effort(), processes=workers or cores())
    console = Console(highlight=False)
    main_contact_study(files or FILES, out, effort, " ".join(words), console)
    typer.echo(str(out / PAGE))


def _check_cluster(scheduler: str | None, workers: int | None) -> None:
    if scheduler is not None and workers is not None:
        problem = "is for a local cluster, not for that of --scheduler"
        raise typer.BadParameter(problem, param_hint="'--workers'")
