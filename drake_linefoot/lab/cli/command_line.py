"""The command `linefoot`: parses, calls, prints.

Drake is imported inside the commands, so that `linefoot --help` is quick.
"""

import logging
import os
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Annotated

import typer

from drake_linefoot import __version__
from drake_linefoot._environment import LOCALE, is_without_utf8
from drake_linefoot.errors import InputError, LinefootError, OutputError, legible
from drake_linefoot.lab.cli import screen
from drake_linefoot.lab.cli.drive import drive
from drake_linefoot.lab.cli.inspect import draw, log, show
from drake_linefoot.lab.cli.new_robot import new_robot
from drake_linefoot.lab.cli.remote import control, latency, simulate
from drake_linefoot.lab.cli.sweep import sweep
from drake_linefoot.lab.cli.walk import replay, walk

app = typer.Typer(
    add_completion=False,
    pretty_exceptions_enable=False,
    help="A line-foot humanoid walks in Drake.",
    epilog=screen.STATUS,
)
COMMANDS: tuple[Callable[..., None], ...] = (
    *(walk, drive, sweep, replay),
    *(log, draw, show, new_robot),
    *(control, simulate, latency),
)
LONGEST, LONGEST_WORD = 2000, 400  # characters of a message, of a word in it
ENDED_EARLY = {
    screen.INTERRUPTED: "interrupted",
    screen.TERMINATED: "terminated",
    screen.HUNG_UP: "hung up",
}
for _command in COMMANDS:
    app.command(epilog=screen.STATUS if _command in (walk, drive, sweep, simulate) else None)(
        _command
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit status.

    Args:
        arguments: words after the program's name; None takes those of the process.
    """
    if is_without_utf8():
        return _complain(f"the locale of the environment {LOCALE}", screen.BAD_INPUT)
    # Of a home that cannot be written, which costs no more than a second.
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    try:
        status = app(args=arguments, prog_name="linefoot", standalone_mode=False)
        sys.stdout.flush()
    except (Exception, KeyboardInterrupt, SystemExit) as error:
        if screen.is_unread(error):
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # Python flushes it last
            return screen.UNREAD
        return _complain(*_meaning(error))
    if status in ENDED_EARLY:
        return _complain(ENDED_EARLY[status], status)
    return int(status or screen.FINE)


def _meaning(error: BaseException) -> tuple[str, int]:
    """Return what to say of an error, and the exit status."""
    if isinstance(error, typer.Abort) or screen.came_of(error, KeyboardInterrupt):
        return ENDED_EARLY[screen.INTERRUPTED], screen.INTERRUPTED
    if isinstance(error, typer.TyperException):
        more = "" if isinstance(error, typer.BadParameter) else " (see linefoot --help)"
        return f"{error.format_message()}{more}", screen.BAD_INPUT
    if isinstance(error, InputError | OutputError):
        return str(error), screen.BAD_INPUT
    if isinstance(error, LinefootError):
        return str(error), screen.BROKE_OFF
    if isinstance(error, OSError) and error.filename is not None:  # too long, or a loop of links
        return f"{error.filename}: cannot be used: {error.strerror}", screen.BAD_INPUT
    # Of Drake's assertions, which are a SystemExit, too.
    return screen.report_of(error), screen.BROKE_OFF


@app.callback(invoke_without_command=True)
def start(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Show versions and exit.")] = False,
) -> None:
    """Say what there is when no command is given."""
    if version:
        from importlib.metadata import version as version_of

        typer.echo(f"drake_linefoot {__version__}, Drake {version_of('drake')}")
        raise typer.Exit(screen.FINE)
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())
        raise typer.Exit(screen.FINE)


def _complain(message: str, status: int) -> int:
    """Print one line on stderr; return the exit status."""
    words = " ".join(legible(word, LONGEST_WORD) for word in message[:LONGEST].split())
    with suppress(OSError, ValueError):  # there may be nobody to tell
        print("linefoot:", legible(words, LONGEST), file=sys.stderr)
    return status
