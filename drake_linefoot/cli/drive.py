"""The command `linefoot drive`. Drake is imported inside it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from signal import SIGTERM
from typing import Annotated

import typer

from drake_linefoot.cli.keep import kept_on_error, write_run
from drake_linefoot.cli.options import (
    Host,
    Length,
    Model,
    Port,
    Robot,
    ScenarioName,
    Seed,
    chosen_scenario,
)
from drake_linefoot.cli.screen import FELL, compile_first, open_live
from drake_linefoot.simulation.quiet import quieten_drake


def drive(
    scenario: ScenarioName = None,
    duration: Length = None,
    seed: Seed = None,
    model: Model = None,
    out: Annotated[
        Path | None, typer.Option(help="Record the session, and write it here at its end.")
    ] = None,
    port: Port = None,
    host: Host = None,
    robot: Robot = None,
) -> None:
    """Drive the robot live in a browser, by keys, sliders or gamepad; Ctrl-C or Quit ends it."""
    from drake_linefoot.drive.drive import Drive
    from drake_linefoot.results.output import check_output_dir

    start = chosen_scenario(scenario, seed, model, robot)
    if out is not None:
        check_output_dir(out)
    quieten_drake()
    compile_first()
    with open_live(host, port, stats=True, what="Drive") as meshcat, _terminal() as say:
        live = Drive(start, meshcat, record=out is not None, say=say)
        session = live.session
        with kept_on_error(session.run, out):
            live.run(duration)
    ended = live.interrupted.number == SIGTERM
    if out is not None:
        typer.echo(str(write_run(session.run(), out, replay=not ended).shown))
    if session.fall:
        typer.echo(f"The robot FELL at {session.time:.3f} s: {session.fall}")
    if session.fall or ended:
        raise typer.Exit(live.interrupted.status if ended else FELL)


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
