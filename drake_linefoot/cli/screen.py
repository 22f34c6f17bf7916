"""What commands share: a bar while functions are compiled, a browser, how they end."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from pydrake.geometry import Meshcat

FINE, FELL, BAD_INPUT, BROKE_OFF, INTERRUPTED = 0, 1, 2, 3, 130
STATUS = (
    "Exit status: 0 fine; 1 the robot fell (everything is written); 2 bad input; "
    "3 the run broke off; 130 interrupted. Nothing is ever half-written."
)


def compile_first() -> None:
    """Compile, with a bar, what has to be compiled before a run that somebody watches."""
    from rich.progress import BarColumn, Progress, TimeElapsedColumn

    from drake_linefoot.wiring.warm_up import warm_up

    bar = Progress(BarColumn(bar_width=20), TimeElapsedColumn(), transient=True)
    bar.disable = not bar.console.is_terminal
    with bar:
        task = bar.add_task("", total=1.0)
        warm_up(typer.echo, lambda share: bar.update(task, completed=share))


def open_live() -> Meshcat:
    """Open a Meshcat server for looking at, and say where."""
    from drake_linefoot.visualization.view import open_meshcat

    meshcat = open_meshcat(public=True)
    typer.echo(f"Live at {meshcat.web_url()}")
    return meshcat
