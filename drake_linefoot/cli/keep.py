"""What was simulated is written, whatever comes: before pictures of it, and after an error."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import typer

from drake_linefoot.errors import LinefootError

if TYPE_CHECKING:
    from drake_linefoot.simulation.recording import Run


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

    from drake_linefoot.results.output import REPLAY, add_replay, forget_unfinished, write_outputs

    replay = replay and len(run.time) > 0
    console = Console()  # whose status shows nothing where there is no terminal
    with console.status("writing log, plots and report"):
        metrics, shown = write_outputs(run, out, replay, rate), out
    try:
        if replay:
            with console.status("drawing the replay"):
                add_replay(run, metrics, out)
            shown = out / REPLAY
    except LinefootError as error:
        typer.echo(f"linefoot: the replay is missing: {error}", err=True)
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
