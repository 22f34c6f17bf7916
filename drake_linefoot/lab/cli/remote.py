"""The commands `linefoot control` and `simulate`: controller and robot in two processes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated

import typer

from drake_linefoot.lab.cli import options, screen
from drake_linefoot.lab.cli.walk import WalkOptions, carry_out
from drake_linefoot.lab.simulation.drake_logging import silence_drake

if TYPE_CHECKING:
    from drake_linefoot.lab.remote.robot import RemoteController
    from drake_linefoot.lab.scenario import Scenario
    from drake_linefoot.robot.humanoid import Humanoid
    from drake_linefoot.wiring.without_simulator import Controller

Url = Annotated[
    str | None,
    typer.Option(metavar="URL", help="Of LCM; else messages stay on this computer."),
]

First = Annotated[
    bool,
    typer.Option("--first", help="Run ticks before all else: SCHED_FIFO, where that is allowed."),
]


@dataclass
class SimulateOptions(WalkOptions):
    """What `linefoot simulate` is given."""

    url: Url = None
    lockstep: Annotated[
        bool, typer.Option("--lockstep", help="Wait for each answer, instead of real time.")
    ] = False


def control(
    scenario: options.ScenarioName = None,
    model: options.Model = None,
    robot: options.Robot = None,
    url: Url = None,
    first: First = False,
) -> None:
    """Control a robot that says its state over LCM, until Ctrl-C."""
    from drake_linefoot.lab.remote.bus import URL, Bus
    from drake_linefoot.lab.remote.control import RemoteControl, serve
    from drake_linefoot.lab.remote.messages import RobotOutput, WalkCommand
    from drake_linefoot.lab.simulation.interruption import interruptions
    from drake_linefoot.robot.humanoid import load_humanoid

    run = options.chosen_scenario(scenario, None, model, robot)
    silence_drake()
    controller = _ready(load_humanoid(run.robot), run, first)
    bus = Bus(RobotOutput, WalkCommand, url=url or URL)
    typer.echo("waits for a robot")
    with interruptions() as interrupted:
        serve(RemoteControl(controller), bus, lambda: interrupted)
    raise typer.Exit(interrupted.status)


@options.takes(SimulateOptions)
def simulate(given: SimulateOptions) -> None:
    """Walk as `linefoot walk`, with the controller that `linefoot control` is, over LCM."""

    def far_away(run: Scenario) -> RemoteController:
        from drake_linefoot.lab.remote.bus import URL, Bus
        from drake_linefoot.lab.remote.messages import RobotInput
        from drake_linefoot.lab.remote.robot import RemoteController
        from drake_linefoot.robot.humanoid import load_humanoid

        bus = Bus(RobotInput, url=given.url or URL)
        return RemoteController(load_humanoid(run.robot), bus, run.period, given.lockstep)

    raise typer.Exit(carry_out(given, far_away, 0.0 if given.lockstep else 1.0))


def latency(
    scenario: options.ScenarioName = None,
    duration: options.Duration = None,
    model: options.Model = None,
    robot: options.Robot = None,
    process: Annotated[
        bool, typer.Option("--process", help="With the MPC in a process of its own.")
    ] = False,
    first: First = False,
) -> None:
    """Walk in real time, and print how long the ticks of the controller take."""
    from rich.console import Console
    from rich.table import Table

    from drake_linefoot.lab.remote.control import RemoteControl
    from drake_linefoot.lab.remote.latency import LocalLine, machine, table_of
    from drake_linefoot.lab.remote.robot import RemoteController
    from drake_linefoot.lab.scenario.edit import with_duration
    from drake_linefoot.lab.simulation.run import simulate as walked
    from drake_linefoot.lab.wiring.closed_loop import build_closed_loop, warm_up
    from drake_linefoot.robot.humanoid import load_humanoid

    run = options.chosen_scenario(scenario, None, model, robot)
    run = run if duration is None else with_duration(run, duration)
    if process:
        run = replace(run, mpc=replace(run.mpc, process=True))
    silence_drake()
    warm_up()
    humanoid = load_humanoid(run.robot)
    controller = _ready(humanoid, run, first)
    line = LocalLine(RemoteControl(controller))
    block = RemoteController(humanoid, line, run.period, lockstep=True)
    done = walked(build_closed_loop(run, controller=block), realtime_rate=1.0)
    table = Table(show_header=False)
    rate = done.time[-1] / done.wall_seconds
    for row in (
        *table_of(line.times, run.period),
        ("plans late or unsolved", f"{controller.look('plan').failures:g}"),
        ("simulated", f"{done.time[-1]:g} s, {rate:.2f} x real time"),
        *machine(),
    ):
        table.add_row(*row)
    Console(highlight=False).print(table)
    raise typer.Exit(screen.FELL if done.fell else screen.FINE)


def _ready(humanoid: Humanoid, run: Scenario, first: bool) -> Controller:
    """Return a controller that is warm, in this process, which then runs `first`."""
    from drake_linefoot.lab.remote.priority import HELPERS, TICKS, run_first
    from drake_linefoot.wiring.without_simulator import Controller

    if first:
        run_first(HELPERS)  # a process of the MPC takes it over
    controller = Controller(humanoid, run, real_time=True)
    controller.warm_up()
    if first:
        run_first(TICKS)
    return controller
