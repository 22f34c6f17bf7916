"""The command `linefoot drive`. Drake is imported inside it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from signal import SIGHUP, SIGTERM
from typing import TYPE_CHECKING, Annotated

import typer

from drake_linefoot.lab.cli import options, screen
from drake_linefoot.lab.simulation.drake_logging import silence_drake

if TYPE_CHECKING:
    from drake_linefoot.lab.scenario import Scenario

PRESS = "W walks, Q and E turn it, X stops it, P pushes it"


@dataclass(frozen=True)
class DriveOptions:
    """What `linefoot drive` is given."""

    scenario: options.ScenarioName = None
    duration: options.Length = None
    seed: options.Seed = None
    model: options.Model = None
    out: Annotated[
        Path | None, typer.Option(help="Record the session, and write it here at its end.")
    ] = None
    port: options.Port = None
    host: options.Host = None
    robot: options.Robot = None
    simulator: options.Simulator = None


@options.takes(DriveOptions)
def drive(given: DriveOptions) -> None:
    """Drive the robot live in a browser, by keys, sliders or gamepad; Ctrl-C or Quit ends it."""
    from drake_linefoot.lab.results.output import check_output_dir, reserved, unfinished
    from drake_linefoot.lab.scenario.load import validate

    with screen.busy("loading the robot"):
        names = given.scenario, given.seed, given.model, given.robot
        start = options.in_simulator(options.chosen_scenario(*names), given.simulator)
        validate(start, "command line")
    out = given.out
    if out is not None:
        check_output_dir(out)
    with (
        nullcontext() if out is None else reserved(out),
        nullcontext() if out is None else unfinished(out, screen.say) as folder,
    ):
        status = _drive(start, given.duration, out, folder, given.host, given.port)
    raise typer.Exit(status)


def _drive(
    start: Scenario,
    duration: float | None,
    out: Path | None,
    folder: Path | None,  # of the samples meanwhile
    host: str | None,
    port: int | None,
) -> int:
    """Drive, write and say how it ended; return the exit status."""
    from drake_linefoot.lab.drive.drive import Drive
    from drake_linefoot.lab.simulation.run import keep_on_disk
    from drake_linefoot.lab.wiring.closed_loop import warm_up

    silence_drake()
    warm_up()
    with screen.open_live(host, port, what="Drive", press=PRESS) as page, _terminal() as say:
        live = Drive(start, page, record=out is not None, say=say)
        session = live.session
        if folder is not None:
            keep_on_disk(session.loop, folder)
        with screen.kept_on_error(session.run, out):
            live.run(duration)
    ended = live.interrupted.number in (SIGTERM, SIGHUP)
    if out is not None:
        run = session.run()
        session.loop.recorder.end(run.facts()[1])
        typer.echo(str(screen.write_run(run, out, replay=not ended).shown))
    if session.fall:
        screen.say(f"The robot FELL at {session.time:.3f} s: {session.fall}")
    if ended:
        return live.interrupted.status
    return screen.FELL if session.fall else screen.FINE


@contextmanager
def _terminal() -> Iterator[Callable[[list[str]], None] | None]:
    """Show what is on screen in the terminal as well; yields None when there is no terminal."""
    from rich.console import Console
    from rich.live import Live
    from rich.text import Text

    console = Console(highlight=False)
    if not console.is_terminal:
        yield None
        return
    with Live(console=console, auto_refresh=False, transient=True) as live:
        yield lambda lines: live.update(Text("\n".join(lines)), refresh=True)
