"""What commands show things on: a browser, a terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer

from drake_linefoot.errors import InputError, LinefootError

if TYPE_CHECKING:
    from pydrake.geometry import Meshcat
    from rich.console import Console

WIDTH = 110  # [letters] of a table that is not printed to a terminal


def wide_console() -> Console:
    """Return a console whose tables are not cut where there is no terminal."""
    from rich.console import Console

    console = Console(highlight=False)
    if not console.is_terminal:
        console.width = WIDTH
    return console


def compile_first() -> None:
    """Compile, with a bar, what has to be compiled before a run that somebody watches."""
    from rich.progress import BarColumn, Progress, TimeElapsedColumn

    from drake_linefoot.wiring.warm_up import warm_up

    bar = Progress(BarColumn(bar_width=20), TimeElapsedColumn(), transient=True)
    bar.disable = not bar.console.is_terminal
    with bar:
        task = bar.add_task("", total=1.0)
        warm_up(typer.echo, lambda share: bar.update(task, completed=share))


def open_meshcat(*, public: bool = False, port: int | None = None, stats: bool = False) -> Meshcat:
    """Open a Meshcat server.

    Args:
        public: whether other machines can reach it.
        port: of its page; None for the first free one.
        stats: whether it shows how fast it draws.
    """
    from pydrake.geometry import Meshcat, MeshcatParams

    host = "*" if public else "localhost"
    try:
        return Meshcat(MeshcatParams(host=host, port=port, show_stats_plot=stats))
    except RuntimeError as error:
        if port is not None:
            raise InputError("--port", "", port, "is taken, or not allowed") from error
        raise LinefootError(f"Meshcat cannot open a port: {error}") from error


def open_live() -> Meshcat:
    """Open a Meshcat server for looking at, and say where."""
    meshcat = open_meshcat(public=True)
    typer.echo(f"Live at {meshcat.web_url()}")
    return meshcat
