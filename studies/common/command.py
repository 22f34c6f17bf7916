"""The command line of a study, `python -m studies.NAME`: how words are read, and how it ends."""

import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated

import typer

from drake_linefoot.errors import InputError, LinefootError, OutputError
from drake_linefoot.lab.simulation.drake_logging import silence_drake
from studies.common.files import prepare

FINE, FELL, BAD_INPUT, BROKE_OFF, INTERRUPTED = 0, 1, 2, 3, 130


def _above_zero(value: int | None) -> int | None:
    if value is not None and value < 1:
        raise typer.BadParameter(f"{value} must be a whole number above 0")
    return value


DOCS, OUT = Path("docs"), Path("out")  # of what is published, and of what is not
SWEEPS = (Path("examples/sweeps/robustness.yaml"), Path("examples/sweeps/punch_tour.yaml"))

Quick = Annotated[bool, typer.Option("--quick", help="Less of everything, for a look.")]
Fresh = Annotated[bool, typer.Option("--fresh", help="Forget what is done.")]
Out = Annotated[Path, typer.Option(help="Folder of the results.")]
PageOut = Annotated[
    Path | None,
    typer.Option(help="Folder of the page; else one of docs/, of a quick look or some cases out/."),
]
First = Annotated[int, typer.Option(min=0, help="Seed of the first run of a group.")]
Processes = Annotated[
    int | None,
    typer.Option(callback=_above_zero, metavar="NUMBER", help="Processes; else one per processor."),
]
Runs = Annotated[
    int | None,
    typer.Option(
        callback=_above_zero,
        metavar="NUMBER",
        help="Of each group, at most; else as the file says.",
    ),
]
Count = Annotated[
    int,
    typer.Option(min=0, metavar="NUMBER", help="Of the worst runs of each group; 0 for none."),
]
Sweeps = Annotated[
    list[Path] | None,
    typer.Argument(metavar="FILE...", help="Sweeps; else robustness and punch_tour."),
]


def folder_of(out: Path | None, study: str, part: bool) -> Path:
    """Return where a study writes, made: `out`, or what it publishes into docs/, a part of it not.

    Raises:
        OutputError: files cannot be written there.
    """
    folder = out or (OUT if part else DOCS) / study
    prepare(folder)
    return folder


def words_of(study: str, quick: bool, **options: tuple[int, int]) -> str:
    """Return the command of a study: options that are given otherwise than they are by default.

    Args:
        study: its module in `studies`.
        quick: whether it is a quick look.
        options: given and default value of each.
    """
    words = [f"python -m studies.{study}", *(["--quick"] if quick else [])]
    words += [f"--{name} {given}" for name, (given, usual) in options.items() if given != usual]
    return " ".join(words)


def run(command: Callable[..., None], name: str, arguments: Sequence[str] | None = None) -> int:
    """Carry out the command `name`, a function with options as typer reads them.

    Returns the exit status. `arguments` are the words after the program's name; None takes those of
    the process.
    """
    silence_drake()
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
