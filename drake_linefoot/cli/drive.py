"""The command `linefoot drive`. Drake is imported inside it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drake_linefoot.cli.options import (
    Length,
    Model,
    Port,
    Robot,
    ScenarioName,
    Seed,
    chosen_scenario,
)
from drake_linefoot.cli.screen import FELL, compile_first
from drake_linefoot.simulation.quiet import quieten_drake

if TYPE_CHECKING:
    from pydrake.geometry import Meshcat

    from drake_linefoot.drive.session import Session


def drive(
    scenario: ScenarioName = None,
    duration: Length = None,
    seed: Seed = None,
    model: Model = None,
    out: Annotated[
        Path | None, typer.Option(help="Record the session, and write it here at its end.")
    ] = None,
    port: Port = None,
    robot: Robot = None,
) -> None:
    """Drive the robot live in a browser, by keys, sliders or gamepad; Ctrl-C or Quit ends it."""
    from drake_linefoot.drive.drive import Drive
    from drake_linefoot.results.output import check_output_dir
    from drake_linefoot.visualization.view import open_meshcat

    start = chosen_scenario(scenario, seed, model, robot)
    if out is not None:
        check_output_dir(out)
    quieten_drake()
    compile_first()
    meshcat = open_meshcat(public=True, port=port, stats=True)
    typer.echo(f"Drive at {meshcat.web_url()}; the keys are on its buttons and sliders")
    with _terminal() as say:
        session = Drive(start, meshcat, record=out is not None, say=say).run(duration)
    if out is not None:
        _write(session, meshcat, out)
    if session.fall:
        typer.echo(f"The robot FELL at {session.time:.3f} s: {session.fall}")
        raise typer.Exit(FELL)


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


def _write(session: Session, meshcat: Meshcat, out: Path) -> None:
    """Write what was recorded as `linefoot walk` does."""
    from drake_linefoot.results.output import REPLAY, write_outputs
    from drake_linefoot.visualization.replay import play, recording, replay_html, run_title

    run = session.run()
    with recording(meshcat):
        play(run, meshcat, realtime_rate=0.0)
    write_outputs(run, replay_html(meshcat, run_title(run)), out)
    typer.echo(str(out / REPLAY))
