"""The options of the command `linefoot`: how a word becomes a value, or is refused."""

from __future__ import annotations

import functools
import inspect
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar, get_type_hints

import typer

from drake_linefoot.lab.cli.screen import say
from drake_linefoot.mpc.models.registry import MODELS

if TYPE_CHECKING:
    from drake_linefoot.lab.scenario import Scenario
    from drake_linefoot.lab.scenario.disturbances import PushParameters

_T = TypeVar("_T")


def _number(allowed: str, holds: Callable[[float], bool]) -> Callable[[str], float]:
    """Return what makes a finite number of a word, or refuses it."""

    def parse(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise typer.BadParameter(f"{text!r} must be a finite number")
        if not holds(value):
            raise typer.BadParameter(f"{text!r} {allowed}")
        return value

    return parse


def _whole(low: int, high: int, allowed: str = "") -> Callable[[str | int], int]:
    """Return what makes a whole number of a word (or of a default), or refuses it."""
    allowed = allowed or f"must be a whole number from {low} to {high}"

    def parse(value: str | int) -> int:
        text = str(value)
        if not (text.isdecimal() and len(text) < 20 and low <= int(text) <= high):
            raise typer.BadParameter(f"{text!r} {allowed}")
        return int(text)

    return parse


def _model(text: str) -> str:
    """Return the name of a model of the MPC."""
    if text not in MODELS:
        raise typer.BadParameter(f"{text!r} must be one of {list(MODELS)}")
    return text


def _option(parser: Callable[..., object], unit: str, about: str) -> Any:
    """Return the declaration of an option whose word `parser` makes a value of."""
    return typer.Option(parser=parser, metavar=unit, help=about)


_WALK = "Stand 1 s, then walk: "
_any = _number("", lambda value: True)
_length = _number("must be a number above 0, in s", lambda value: value > 0.0)
_since = _number("must be a number from 0 on, in s", lambda value: value >= 0.0)
_hertz = _number("must be a number from 1 to 1e6, in Hz", lambda value: 1.0 <= value <= 1e6)
_seed = _whole(0, 2**63 - 1)
_port = _whole(1, 65535)
_processes = _whole(1, 9999, "must be a whole number above 0")
_count = _whole(0, 999999, "must be a whole number, not negative")
_how_long = "Length of the run: stops earlier, or holds the last segment for longer."

ScenarioName = Annotated[
    str | None,
    typer.Argument(
        metavar="SCENARIO",
        help="Name of a shipped one, or a YAML file; else the robot's own, or walk.",
    ),
]
Robot = Annotated[
    Path | None,
    typer.Option(
        metavar="DIR", help="Folder that `linefoot new-robot` wrote, or a robot's YAML file."
    ),
]
Duration = Annotated[float | None, _option(_length, "SECONDS", _how_long)]
Forward = Annotated[float | None, _option(_any, "M/S", f"{_WALK}forward velocity.")]
Left = Annotated[float | None, _option(_any, "M/S", f"{_WALK}velocity to the left.")]
Turn = Annotated[float | None, _option(_any, "RAD/S", f"{_WALK}turn to the left.")]
Seed = Annotated[int | None, _option(_seed, "NUMBER", "Of everything random.")]
Model = Annotated[
    str | None,
    _option(_model, "NAME", "Model of the MPC; a name that there is not lists those there are."),
]
Estimate = Annotated[
    bool, typer.Option("--estimate", help="Walk on an estimate of the state, not on the truth.")
]
Simulator = Annotated[
    str | None, typer.Option(metavar="NAME", help="drake or mujoco; else that of the scenario.")
]
Mjcf = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="Walk in MuJoCo, in this model with the robot on a ground."),
]
Pushes = Annotated[
    list[str] | None,
    typer.Option(
        metavar="S,N S[,RAD]",
        help="Push the torso: time, impulse, direction, as 2,15,1.57; may be repeated.",
    ),
]
Fields = Annotated[
    list[str] | None,
    typer.Option(
        metavar="FIELD=VALUE",
        help="Of the scenario, such as gait.swing_height=0.08; may be repeated.",
    ),
]
Begin = Annotated[
    float | None, _option(_since, "SECONDS", "Where to begin; else two minutes before the end.")
]
LogRate = Annotated[float | None, _option(_hertz, "HZ", "Rate of log.arrow; else every tick.")]
Length = Annotated[float | None, _option(_length, "SECONDS", "End by itself after this wall time.")]
Port = Annotated[int | None, _option(_port, "NUMBER", "Of the page; else the first free one.")]
Host = Annotated[
    str | None,
    typer.Option(metavar="NAME", help="Open the page to others: 0.0.0.0, or one of our addresses."),
]
Processes = Annotated[
    int | None, _option(_processes, "NUMBER", "Processes; else one per processor.")
]
Count = Annotated[int, _option(_count, "NUMBER", "Of the worst runs of each group; 0 for none.")]
Scheduler = Annotated[
    str | None,
    typer.Option(metavar="ADDRESS", help="Use the cluster of this dask scheduler, tcp://..."),
]


def takes(options: type[_T]) -> Callable[[Callable[[_T], None]], Callable[..., None]]:
    """Return a decorator of a command with many options: they are the fields of a dataclass.

    Args:
        options: the dataclass. Typer makes an option of each of its fields; the command gets one
            object.
    """
    hints = get_type_hints(options, include_extras=True)
    fields = inspect.signature(options).parameters.values()
    signature = inspect.Signature([each.replace(annotation=hints[each.name]) for each in fields])

    def decorate(command: Callable[[_T], None]) -> Callable[..., None]:
        @functools.wraps(command)
        def call(**given: object) -> None:
            command(options(**given))

        call.__signature__ = signature  # type: ignore[attr-defined]
        return call

    return decorate


def fields_of(texts: Sequence[str]) -> dict[str, object]:
    """Return what texts like "mpc.model=srbm" say: values, as YAML has them, by their fields."""
    from drake_linefoot.yaml_file import load_yaml

    given: dict[str, object] = {}
    for text in texts:
        field, equals, value = text.partition("=")
        if not (field and equals):
            raise typer.BadParameter(f"{text!r} must be FIELD=VALUE", param_hint="'--set'")
        given[field.strip()] = load_yaml(value, f"--set {field}")
    return given


def in_simulator(scenario: Scenario, simulator: str | None) -> Scenario:
    """Return a scenario in the simulator that is named, if one is; not checked yet."""
    if simulator is None:
        return scenario
    return replace(scenario, plant=replace(scenario.plant, simulator=simulator))


def push_of(text: str) -> PushParameters:
    """Return the push that a text like "2.0,15,1.57" says: time, impulse, direction."""
    from drake_linefoot.lab.scenario.disturbances import PushParameters

    try:
        time, impulse, *direction = (_any(word) for word in text.split(","))
        return PushParameters(time, 0.1, impulse, *direction)
    except (ValueError, TypeError, typer.BadParameter) as error:
        allowed = "must be a time [s], an impulse [N s] and, if not forward, a direction [rad]"
        raise typer.BadParameter(f"{text!r} {allowed}", param_hint="'--push'") from error


def chosen_scenario(
    name: str | None,
    seed: int | None,
    model: str | None,
    robot: Path | None = None,
    fields: Mapping[str, object] | None = None,
) -> Scenario:
    """Return a scenario with the seed, the model of the MPC, robot and `fields` that are given.

    Without a name it is that of the robot's folder. A robot of a user's own is loaded first, so
    that what is wrong with it is said before anything else; what was done to it is printed.
    """
    from drake_linefoot.lab.new_robot.folder import scenario_beside
    from drake_linefoot.lab.scenario.load import load_scenario
    from drake_linefoot.robot.description import robot_file
    from drake_linefoot.robot.humanoid import load_humanoid

    overrides: dict[str, object] = {"seed": seed, "mpc.model": model}
    if robot is not None:
        file = robot_file(robot)
        overrides["robot"] = str(file)
        name = name or scenario_beside(file)
        for note in load_humanoid(file).notes:
            say(f"{file.stem}: {note}")
    given = {field: value for field, value in overrides.items() if value is not None}
    given |= fields or {}
    scenario = load_scenario(name or "walk", given)
    if robot is None:
        load_humanoid(scenario.robot)
    return scenario
