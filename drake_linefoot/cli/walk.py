"""The commands `linefoot walk` and `replay`. Drake is imported inside them."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drake_linefoot.cli import options
from drake_linefoot.cli.screen import FELL, compile_first, open_live
from drake_linefoot.simulation.quiet import quieten_drake

if TYPE_CHECKING:
    from drake_linefoot.scenario import Scenario


@dataclass
class WalkOptions:
    """What `linefoot walk` is given."""

    scenario: options.ScenarioName = None
    duration: options.Duration = None
    vx: options.Forward = None
    vy: options.Left = None
    turn: options.Turn = None
    seed: options.Seed = None
    out: Annotated[Path, typer.Option(help="Folder of the results.")] = Path("out/walk")
    model: options.Model = None
    robot: options.Robot = None
    live: Annotated[bool, typer.Option("--live", help="Show it in a browser meanwhile.")] = False
    replay: Annotated[bool, typer.Option(help="Write replay.html.")] = True


@options.takes(WalkOptions)
def walk(given: WalkOptions) -> None:
    """Simulate a scenario; write replay, log, plots and metrics."""
    from drake_linefoot.results.output import check_output_dir
    from drake_linefoot.scenario.edit import with_command, with_duration

    run = options.chosen_scenario(given.scenario, given.seed, given.model, given.robot)
    velocity = given.vx, given.vy, given.turn
    if velocity != (None, None, None):
        run = with_command(run, *(part or 0.0 for part in velocity))
    if given.duration is not None:
        run = with_duration(run, given.duration)
    check_output_dir(given.out)
    if not _simulate(run, given.out, given.live, given.replay):
        raise typer.Exit(FELL)


def replay(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="What `linefoot walk` wrote.")],
    loop_once: Annotated[bool, typer.Option("--loop-once", help="Show it once and end.")] = False,
    rate: options.Rate = 1.0,
) -> None:
    """Show a recorded run in a browser, over and over, until Ctrl-C."""
    from drake_linefoot.simulation.recording import Run
    from drake_linefoot.visualization.replay import play

    quieten_drake()
    run = Run.load(folder)
    meshcat = open_live()
    play(run, meshcat, rate)
    while not loop_once:
        play(run, meshcat, rate)


def _simulate(scenario: Scenario, out: Path, live: bool, replay: bool) -> bool:
    """Simulate, write and print; return whether the robot stayed up."""
    from rich.console import Console

    from drake_linefoot.results import tables
    from drake_linefoot.results.metrics import compute_metrics
    from drake_linefoot.results.output import REPLAY, write_outputs
    from drake_linefoot.simulation.run import simulate
    from drake_linefoot.visualization.replay import recording, replay_html, run_title
    from drake_linefoot.visualization.view import open_meshcat
    from drake_linefoot.wiring.closed_loop import build_closed_loop

    quieten_drake()
    console = Console(highlight=False)
    compile_first()
    meshcat = open_live() if live else open_meshcat() if replay else None
    loop = build_closed_loop(scenario, meshcat)
    recorded = recording(meshcat) if meshcat and replay else nullcontext()
    with tables.progress_bar(console) as progress, recorded:
        run = simulate(loop, progress, realtime_rate=1.0 if live else 0.0)
    page = replay_html(meshcat, run_title(run)) if meshcat and replay else None
    write_outputs(run, page, out)
    metrics = compute_metrics(run)
    console.print(tables.segment_table(metrics), tables.summary_table(metrics))
    if run.fell:
        console.print(f"The robot FELL at {run.fall_time:.3f} s: {run.fall_reason}", markup=False)
    typer.echo(str(out / REPLAY if replay else out))
    return not run.fell
