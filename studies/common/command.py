"""The command line of a study, `python -m studies.NAME`: how words are read, and how it ends."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from drake_linefoot.errors import InputError, LinefootError, OutputError
from drake_linefoot.simulation.quiet import quieten_drake

if TYPE_CHECKING:
    from pydrake.geometry import Meshcat

FINE, FELL, BAD_INPUT, BROKE_OFF, INTERRUPTED = 0, 1, 2, 3, 130
WIDTH = 110  # [letters] of a table that is not printed to a terminal


def _count(value: str | int) -> int:
    """Return a number of things of which there may be none; `value` may be the default."""
    text = str(value)
    if not (text.isdecimal() and len(text) < 7):
        raise typer.BadParameter(f"{text!r} must be a whole number, not negative")
    return int(text)


def _above_zero(text: str) -> int:
    if _count(text) == 0:
        raise typer.BadParameter(f"{text!r} must be a whole number above 0")
    return int(text)


Quick = Annotated[bool, typer.Option("--quick", help="Less of everything, for a look.")]
Fresh = Annotated[bool, typer.Option("--fresh", help="Forget what is done.")]
Out = Annotated[Path, typer.Option(help="Folder of the results.")]
Processes = Annotated[
    int | None,
    typer.Option(parser=_above_zero, metavar="NUMBER", help="Processes; else one per processor."),
]
Runs = Annotated[
    int | None,
    typer.Option(
        parser=_above_zero, metavar="NUMBER", help="Of each group; else as the file says."
    ),
]
Count = Annotated[
    int,
    typer.Option(
        parser=_count, metavar="NUMBER", help="Of the worst runs of each group; 0 for none."
    ),
]
Sweeps = Annotated[
    list[Path] | None,
    typer.Argument(metavar="FILE...", help="Sweeps; else examples/sweeps, nominal and robustness."),
]


def run(command: Callable[..., None], name: str, arguments: Sequence[str] | None = None) -> int:
    """Carry out the command of a study; return the exit status.

    Args:
        command: a function with options, as typer reads them.
        name: of the study.
        arguments: words after the program's name; None takes those of the process.
    """
    quieten_drake()
    app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
    app.command()(command)
    message = ""
    try:
        status = app(args=arguments, prog_name=f"python -m studies.{name}", standalone_mode=False)
    except typer.TyperException as error:
        status, message = BAD_INPUT, error.format_message()
    except LinefootError as error:
        bad = isinstance(error, InputError | OutputError)
        status, message = BAD_INPUT if bad else BROKE_OFF, str(error)
    except (KeyboardInterrupt, typer.Abort):
        status = INTERRUPTED
    message = "interrupted" if status == INTERRUPTED else " ".join(message.split())
    if message:
        print(f"studies.{name}: {message}", file=sys.stderr)
    return int(status or FINE)


def console() -> Console:
    """Return a console whose tables are not cut where there is no terminal."""
    made = Console(highlight=False)
    if not made.is_terminal:
        made.width = WIDTH
    return made


def open_meshcat() -> Meshcat:
    """Open a Meshcat server, from which replays are made.

    Raises:
        LinefootError: there is no port for it.
    """
    from pydrake.geometry import Meshcat, MeshcatParams

    try:
        return Meshcat(MeshcatParams(host="localhost", show_stats_plot=False))
    except RuntimeError as error:
        raise LinefootError(f"Meshcat cannot open a port: {error}") from error
