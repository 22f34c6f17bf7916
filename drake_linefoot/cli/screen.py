"""What commands share: a bar while functions are compiled, a browser, how they end."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import typer

from drake_linefoot.cli.crash import is_interrupt

if TYPE_CHECKING:
    from drake_linefoot.visualization.live import Live

FINE, FELL, BAD_INPUT, BROKE_OFF, INTERRUPTED, UNREAD, TERMINATED = 0, 1, 2, 3, 130, 141, 143
STATUS = (
    "Exit status: 0 fine; 1 the robot fell (everything is written); 2 bad input; 3 the run broke "
    "off, or a crash; 130 interrupted; 141 nobody reads what it prints; 143 terminated. Nothing is "
    "ever half-written."
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


@contextmanager
def until_interrupted() -> Iterator[None]:
    """Let Ctrl-C be the end of what goes on inside the `with` block, as of a drive."""
    try:
        yield
    except (Exception, KeyboardInterrupt) as error:
        if not is_interrupt(error):
            raise


@contextmanager
def open_live(
    host: str | None, port: int | None = None, *, what: str = "Live", path: str = ""
) -> Iterator[Live]:
    """Open a page to look at inside the `with` block, and say where.

    Args:
        host: to listen on; None for this machine only.
        port: of the page; None for the first free one.
        what: the page is for.
        path: "drive/" for the driving page.
    """
    from drake_linefoot.visualization.live import LOCAL, live_page

    with live_page(host or LOCAL, port) as page:
        typer.echo(f"{what} at {page.url}{path}")
        if page.open:
            typer.echo("Other machines reach it, too: who has this address can look and drive")
        yield page
