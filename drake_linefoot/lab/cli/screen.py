"""What commands share: a browser, what is kept, how they end.

What was simulated is written, whatever comes: before pictures of it, and after an error.
"""

from __future__ import annotations

import errno
import tempfile
import traceback
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import typer

from drake_linefoot.errors import LinefootError, legible

if TYPE_CHECKING:
    from drake_linefoot.lab.simulation.recording import Run
    from drake_linefoot.lab.visualization.live import Live

FINE, FELL, BAD_INPUT, BROKE_OFF, INTERRUPTED, UNREAD, TERMINATED = 0, 1, 2, 3, 130, 141, 143
HUNG_UP = 129
LONGEST_LINE = 1000  # characters of what is printed on one line
STATUS = (
    "Exit status: 0 fine; 1 the robot fell (everything is written); 2 bad input; 3 the run broke "
    "off, or a crash; 129 hung up; 130 interrupted; 141 nobody reads what it prints; 143 "
    "terminated. Nothing is ever half-written."
)


@contextmanager
def until_interrupted() -> Iterator[None]:
    """Let Ctrl-C be the end of what goes on inside the `with` block, as of a drive."""
    try:
        yield
    except (Exception, KeyboardInterrupt) as error:
        if not came_of(error, KeyboardInterrupt):
            raise


@contextmanager
def open_live(
    host: str | None, port: int | None = None, *, what: str = "Live", press: str
) -> Iterator[Live]:
    """Open a page to look at inside the `with` block, and say where, and what to press there.

    Args:
        host: to listen on; None for this machine only.
        port: of the page; None for the first free one.
        what: the page is for.
        press: what to press.
    """
    from drake_linefoot.lab.visualization.live import LOCAL, live_page

    with live_page(host or LOCAL, port) as page:
        announce(page, what, press)
        yield page


def busy(what: str) -> AbstractContextManager[object]:
    """Say in a terminal what goes on in the `with` block, with something that moves."""
    from rich.console import Console

    return Console(stderr=True).status(f"{what} ...")


def announce(page: Live, what: str, press: str) -> None:
    """Say where a page is, and what to press there; see `open_live`."""
    from drake_linefoot.lab.visualization.live import VIEW

    typer.echo(f"{what} at {page.url}{VIEW}\n{press}; Ctrl-C here ends it")
    if page.open:
        typer.echo("Other machines reach it, too: who has this address can look and drive")


def say(text: str) -> None:
    """Print a line that may have names and words of a file in it, as `legible` shows them."""
    typer.echo(legible(text, LONGEST_LINE))


class Written(NamedTuple):
    """What was written of a run."""

    metrics: dict[str, Any]
    shown: Path  # what to open: the replay, or the folder without one


def write_run(run: Run, out: Path, replay: bool, rate: float | None = None) -> Written:
    """Write a run, and then its replay; say so when it is missing. Its samples may be gone then.

    Args:
        run: what was recorded.
        out: the folder.
        replay: whether to draw the replay.
        rate: of the samples in its log [Hz]; None for all.
    """
    from rich.console import Console

    from drake_linefoot.lab.results.output import (
        REPLAY,
        add_replay,
        forget_unfinished,
        replay_begun,
        write_outputs,
    )

    replay = replay and len(run.time) > 0
    console = Console()  # whose status shows nothing where there is no terminal
    with replay_begun(out) if replay else nullcontext() as begun:
        with console.status("writing log, plots and report"):
            metrics, shown = write_outputs(run, out, replay, rate), out
        try:
            if replay:
                with console.status("drawing the replay"):
                    add_replay(run, metrics, out, begun)
                shown = out / REPLAY
        except LinefootError as error:
            typer.echo(legible(f"linefoot: the replay is missing: {error}", LONGEST_LINE), err=True)
    forget_unfinished(out)
    return Written(metrics, shown)


@contextmanager
def kept_on_error(
    recorded: Callable[[], Run | None], out: Path | None, rate: float | None = None
) -> Iterator[None]:
    """Write what was recorded when simulating it inside the `with` block ends with an error.

    Args:
        recorded: returns the run so far; None when there is none.
        out: the folder; None to write nothing.
        rate: of the samples in its log [Hz]; None for all.
    """
    try:
        yield
    except (Exception, SystemExit):  # Drake's assertions are a SystemExit
        if out is not None and (run := recorded()) is not None:
            typer.echo(str(write_run(run, out, replay=False, rate=rate).shown))
        raise


def came_of(error: BaseException, kind: type[BaseException]) -> bool:
    """Whether an error is of a kind, or came of one that is.

    A Ctrl-C comes out of compiled code as a SystemError; when the reader of what is printed has
    gone, as `head` does, Rich makes a SystemExit of the BrokenPipeError.
    """
    seen: set[int] = set()
    left: list[BaseException | None] = [error]
    while left:
        each = left.pop()
        if isinstance(each, kind):
            return True
        if each is not None and id(each) not in seen:
            seen.add(id(each))
            left += [each.__cause__, each.__context__]
    return False


def is_unread(error: BaseException) -> bool:
    """Whether an error is that nobody takes what is printed: a reader has gone, a disk is full.

    What is written into files raises an OutputError instead.
    """
    is_full = isinstance(error, OSError) and error.errno in (errno.ENOSPC, errno.EIO)
    own = isinstance(error, LinefootError) or getattr(error, "filename", None) is not None
    return came_of(error, BrokenPipeError) or (is_full and not own)


def report_of(error: BaseException) -> str:
    """Keep the traceback of an error in a file; return one line that names both."""
    said = legible(f"{type(error).__name__}: {error}" if str(error) else type(error).__name__)
    where = "the traceback could not be kept"
    with suppress(OSError):
        where = f"its traceback is in {_keep(error)}"
    return f"unexpected error, {said} ({where})"


def _keep(error: BaseException) -> Path:
    with tempfile.NamedTemporaryFile(
        "w", prefix="linefoot-", suffix=".txt", encoding="utf-8", errors="replace", delete=False
    ) as file:
        file.writelines(traceback.format_exception(error))
    return Path(file.name)
