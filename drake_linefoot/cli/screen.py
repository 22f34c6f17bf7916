"""What commands show before and beside a run: a bar while functions are compiled, a browser."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from pydrake.geometry import Meshcat


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
