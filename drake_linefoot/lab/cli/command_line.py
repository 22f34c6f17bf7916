"""The command `linefoot`: parses, calls, prints.

Drake is imported inside the commands, so that `linefoot --help` is quick.
"""

import os
import sys
from collections.abc import Callable, Sequence
from typing import Annotated

import typer

from drake_linefoot import __version__
from drake_linefoot.errors import InputError, LinefootError, OutputError
from drake_linefoot.lab.cli import screen
from drake_linefoot.lab.cli.drive import drive
from drake_linefoot.lab.cli.inspect import draw, log, show
from drake_linefoot.lab.cli.new_robot import new_robot
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
)
ENDED_EARLY = {
    screen.INTERRUPTED: "interrupted",
    screen.TERMINATED: "terminated",
    screen.HUNG_UP: "hung up",
}
for _command in COMMANDS:
    app.command(epilog=screen.STATUS if _command in (walk, drive, sweep) else None)(_command)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit status.

    Args:
        arguments: words after the program's name; None takes those of the process.
    """
    try:
        status = app(args=arguments, prog_name="linefoot", standalone_mode=False)
    except (Exception, KeyboardInterrupt, SystemExit) as error:
        if screen.came_of(error, BrokenPipeError):
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
    if isinstance(error, typer.BadParameter):
        return error.format_message(), screen.BAD_INPUT
    if isinstance(error, typer.TyperException):
        return f"{error.format_message()} (see linefoot --help)", screen.BAD_INPUT
    if isinstance(error, InputError | OutputError):
        return str(error), screen.BAD_INPUT
    if isinstance(error, LinefootError):
        return str(error), screen.BROKE_OFF
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
    print("linefoot:", " ".join(message.split()), file=sys.stderr)
    return status
