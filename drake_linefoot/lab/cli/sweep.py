"""The command `linefoot sweep`. Drake is imported inside it."""

from pathlib import Path
from typing import Annotated

import typer

from drake_linefoot.lab.cli.options import Count, Processes, Scheduler, Simulator
from drake_linefoot.lab.cli.screen import BROKE_OFF
from drake_linefoot.lab.simulation.drake_logging import silence_drake


def sweep(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="The sweep, a YAML file.")],
    out: Annotated[
        Path | None, typer.Option(help="Folder of the results; else out/sweep/NAME.")
    ] = None,
    workers: Processes = None,
    scheduler: Scheduler = None,
    replays: Count = 3,
    fresh: Annotated[bool, typer.Option("--fresh", help="Forget what is done.")] = False,
    retry: Annotated[
        bool, typer.Option("--retry", help="Do runs without an outcome again.")
    ] = False,
    simulator: Simulator = None,
) -> None:
    """Carry out a batch of random runs, or go on with it; write table, report and replays."""
    from drake_linefoot.lab.results.tables import wide_console
    from drake_linefoot.lab.sweep.main import Options, main_sweep

    if scheduler is not None and workers is not None:
        problem = "is for this machine, not for the cluster of --scheduler"
        raise typer.BadParameter(problem, param_hint="'--workers'")
    silence_drake()
    options = Options(out, workers, scheduler, fresh, replays, retry=retry, simulator=simulator)
    report, complete = main_sweep(file, options, wide_console())
    typer.echo(str(report))
    if not complete:
        raise typer.Exit(BROKE_OFF)
