"""The commands `linefoot control` and `simulate`: controller and robot in two processes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import typer

from drake_linefoot.lab.cli import options
from drake_linefoot.lab.cli.walk import WalkOptions, carry_out
from drake_linefoot.lab.simulation.drake_logging import silence_drake

if TYPE_CHECKING:
    from drake_linefoot.lab.remote.robot import RemoteController
    from drake_linefoot.lab.scenario import Scenario

Url = Annotated[
    str | None,
    typer.Option(metavar="URL", help="Of LCM; else messages stay on this computer."),
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
) -> None:
    """Control a robot that says its state over LCM, until Ctrl-C."""
    from drake_linefoot.lab.remote.bus import URL, Bus
    from drake_linefoot.lab.remote.control import RemoteControl, serve
    from drake_linefoot.lab.remote.messages import RobotOutput, WalkCommand
    from drake_linefoot.lab.simulation.interruption import interruptions
    from drake_linefoot.robot.humanoid import load_humanoid
    from drake_linefoot.wiring.without_simulator import Controller

    run = options.chosen_scenario(scenario, None, model, robot)
    silence_drake()
    controller = Controller(load_humanoid(run.robot), run)
    controller.warm_up()
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
