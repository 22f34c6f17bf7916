"""The commands that look into things: `linefoot log`. Drake is imported inside them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

WIDTH = 110  # [letters] of a table that is not printed to a terminal


def log(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="What `linefoot walk` wrote.")],
    mcap: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the run as MCAP to this file.")
    ] = None,
    rate: Annotated[
        float | None, typer.Option(metavar="HZ", help="Of its messages; else 200, see --mcap.")
    ] = None,
) -> None:
    """Print the channels of a run: units, shapes, rates, sizes; or write its MCAP log anew."""
    from rich.console import Console

    from drake_linefoot.report import log_table
    from drake_linefoot.simulation.log_summary import summarize_log
    from drake_linefoot.simulation.mcap_log import RATE, mcap_log
    from drake_linefoot.simulation.output import write_file
    from drake_linefoot.simulation.recording import Run

    if mcap is not None:
        write_file(mcap, mcap_log(Run.load(folder), RATE if rate is None else rate))
        typer.echo(str(mcap))
        return
    if rate is not None:
        raise typer.BadParameter("needs --mcap", param_hint="'--rate'")
    console = Console(highlight=False)
    if not console.is_terminal:
        console.width = WIDTH
    console.print(log_table(summarize_log(folder)))
