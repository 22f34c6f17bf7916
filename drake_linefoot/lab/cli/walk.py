"""The commands `linefoot walk` and `replay`. Drake is imported inside them."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drake_linefoot.lab.cli import options, screen
from drake_linefoot.lab.simulation.drake_logging import silence_drake

if TYPE_CHECKING:
    from pydrake.systems.framework import System

    from drake_linefoot.lab.scenario import Scenario


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
    estimate: options.Estimate = False
    simulator: options.Simulator = None
    mjcf: options.Mjcf = None
    push: options.Pushes = None
    set: options.Fields = None
    live: Annotated[bool, typer.Option("--live", help="Show it in a browser meanwhile.")] = False
    host: options.Host = None
    port: options.Port = None
    log: options.LogRate = None
    replay: Annotated[bool, typer.Option(help="Write replay.html.")] = True


@options.takes(WalkOptions)
def walk(given: WalkOptions) -> None:
    """Simulate a scenario; write replay, log, plots and metrics."""
    raise typer.Exit(carry_out(given))


def carry_out(
    given: WalkOptions,
    controller: Callable[[Scenario], System] | None = None,
    rate: float | None = None,
) -> int:
    """Simulate, write and print what is asked for; return the exit status.

    Args:
        given: the words.
        controller: makes one that is used instead of ours.
        rate: of real time; None for that of the words.
    """
    from drake_linefoot.lab.results.output import check_output_dir, reserved, unfinished
    from drake_linefoot.lab.scenario.edit import with_command, with_duration
    from drake_linefoot.lab.scenario.load import validate

    names = given.scenario, given.seed, given.model, given.robot
    with screen.busy("loading the robot"):
        run = options.chosen_scenario(*names, options.fields_of(given.set or []))
    run = replace(run, estimation=run.estimation or given.estimate)
    run = replace(run, pushes=[*run.pushes, *map(options.push_of, given.push or [])])
    run = options.in_simulator(run, given.simulator)
    if given.mjcf is not None:
        mujoco = replace(run.plant.mujoco, mjcf=str(given.mjcf))
        run = replace(run, plant=replace(run.plant, simulator="mujoco", mujoco=mujoco))
    velocity = given.vx, given.vy, given.turn
    if velocity != (None, None, None):
        run = with_command(run, *(part or 0.0 for part in velocity))
    walks = any(segment.walk for segment in run.segments)
    if given.duration is not None:
        run = with_duration(run, given.duration)
    if walks and not any(segment.walk for segment in run.segments):
        standing = sum(segment.duration for segment in run.segments)
        typer.echo(f"too short to walk: the first {standing:g} s are spent standing")
    validate(run, "command line")  # before anything is compiled
    check_output_dir(given.out)
    with reserved(given.out), unfinished(given.out, screen.say) as folder:
        return _simulate(run, given, folder, controller and controller(run), rate)


def replay(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="What `linefoot walk` wrote.")],
    loop_once: Annotated[bool, typer.Option("--loop-once", help="Draw it and end.")] = False,
    begin: options.Begin = None,
    host: options.Host = None,
    port: options.Port = None,
) -> None:
    """Show a recorded run in a browser, two minutes of it at most, until Ctrl-C."""
    from drake_linefoot.errors import InputError
    from drake_linefoot.lab.simulation.log import WHAT
    from drake_linefoot.lab.simulation.recording import Run
    from drake_linefoot.lab.visualization.live import LOCAL, live_page
    from drake_linefoot.lab.visualization.page_access import INDEX
    from drake_linefoot.lab.visualization.replay import draw

    silence_drake()
    run = Run.load(folder)
    if not len(run.time):
        raise InputError(folder, "", WHAT, "has no sample: it ended before the first one")
    with screen.until_interrupted(), live_page(host or LOCAL, port) as page:
        with screen.busy("drawing the replay"):
            (page.link.files / INDEX).write_text(draw(run, page.meshcat, begin), encoding="utf-8")
        screen.announce(page, "Replay", "Space plays and pauses it")
        while not loop_once:
            time.sleep(1.0)


def _simulate(
    scenario: Scenario,
    given: WalkOptions,
    folder: Path,
    controller: System | None,
    rate: float | None,
) -> int:
    """Simulate, write and print; return the exit status; `folder` is for its samples meanwhile."""
    from rich.console import Console

    from drake_linefoot.lab.drive.telemetry import follow
    from drake_linefoot.lab.results import tables
    from drake_linefoot.lab.scenario.edit import warnings_of
    from drake_linefoot.lab.simulation.interruption import interruptions
    from drake_linefoot.lab.simulation.run import keep_on_disk, run_so_far, simulate
    from drake_linefoot.lab.wiring.closed_loop import build_closed_loop, warm_up

    silence_drake()
    console = Console(highlight=False)
    warm_up()
    press = "C changes the camera"
    page = screen.open_live(given.host, given.port, press=press) if given.live else nullcontext()
    with page as live, interruptions() as interrupted:
        with screen.busy("building the closed loop"):
            loop = build_closed_loop(scenario, live and live.meshcat, controller)
        for warning in warnings_of(loop.scenario):
            screen.say(warning)
        keep_on_disk(loop, folder)
        recorded = partial(run_so_far, loop)
        if rate is None:
            rate = 1.0 if given.live else 0.0
        with (
            tables.progress_bar(console) as progress,
            screen.kept_on_error(recorded, given.out, given.log),
        ):
            look = live and follow(loop, live.link, f"{scenario.name}, live")
            run = simulate(loop, progress, rate, look, stop=lambda: interrupted)
            loop.recorder.end(run.facts()[1])
        written = screen.write_run(run, given.out, given.replay and not interrupted, given.log)
    if written.metrics["duration_s"]:
        found = written.metrics
        shown = [tables.segment_table(found), tables.gait_table(found), tables.summary_table(found)]
        console.print(*(table for table in shown if table.row_count))
    if run.fell:
        screen.say(f"The robot FELL at {run.fall_time:.3f} s: {run.fall_reason}")
    typer.echo(str(written.shown))
    return interrupted.status or (screen.FELL if run.fell else screen.FINE)
