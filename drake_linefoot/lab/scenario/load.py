"""Scenarios in and out of YAML, with errors that name file, field, value and what is allowed."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from drake_linefoot.checks import check, plain, shown
from drake_linefoot.errors import ScenarioError
from drake_linefoot.fields import RENAMED, ScaledDefault
from drake_linefoot.lab.scenario import paths
from drake_linefoot.lab.scenario.scene import read_part, scene_of
from drake_linefoot.lab.scenario.schema import Scenario
from drake_linefoot.resources import robot_files, scenario_files, scene_files
from drake_linefoot.robot.description import HumanoidDescription, load_description, robot_file
from drake_linefoot.yaml_file import load_yaml, read_yaml

_Dumper: Any = getattr(yaml, "CSafeDumper", yaml.SafeDumper)  # that in C is 10 times as fast


def scenario_file(name_or_path: str | Path) -> Path:
    """Return the file of a scenario; a shipped name goes before a path.

    Raises:
        ScenarioError: it is neither a shipped name nor the path of a file.
    """
    name = str(name_or_path)
    path = scenario_files().get(name, Path(name))
    try:
        exists, folder = path.exists(), path.is_dir()
    except (OSError, ValueError):  # a name too long, a null character
        exists, folder = False, False
    if folder:
        raise ScenarioError("scenario", "", shown(name), "is a folder; must be a YAML file")
    if not exists:
        shipped = list(scenario_files())
        allowed = f"no such file; must be one of {shipped}, or the path of a YAML file"
        raise ScenarioError("scenario", "", shown(name), allowed)
    return path


def load_scenario(
    name_or_path: str | Path, overrides: Mapping[str, object] | None = None
) -> Scenario:
    """Read and check a scenario; what the file does not name keeps its default.

    Paths in it go by its folder, or by the current one where nothing is there.

    Args:
        name_or_path: a shipped name, or the path of a YAML file.
        overrides: dotted field -> value, for instance ``{"mpc.model": "srbm", "seed": 3}`` or
            ``{"pushes[0].time": 2.0}``; they take the place of what the file says.

    Returns:
        The scenario.

    Raises:
        ScenarioError: there is no such file, it is no YAML, or it is no scenario.
    """
    file = scenario_file(name_or_path)
    scenario = make_scenario(_from(file.parent, read_yaml(file, "scenario")), file)
    if overrides:
        data = plain(scenario)
        for entry, value in overrides.items():
            try:
                paths.put(data, entry, plain(value))
            except KeyError as error:
                name = RENAMED.get(entry.rpartition(".")[2])
                allowed = "no such field" + (f"; it is called {name} now" if name else "")
                raise ScenarioError(file, entry, shown(value), allowed) from error
        scenario = make_scenario(data, file)
    validate(scenario, file)
    return scenario


def _from(folder: Path, data: Any) -> Any:
    """Return the data of a scenario with paths that go by its folder, where something is there."""
    places: list[tuple[Any, str]] = [(data, "robot"), (data, "scene")]
    if isinstance(data, dict) and isinstance(plant := data.get("plant"), dict):
        places.append((plant.get("mujoco"), "mjcf"))
    if isinstance(data, dict):
        places.append((data.get("terrain"), "file"))
    for part, key in places:
        name = part.get(key) if isinstance(part, dict) else None
        if isinstance(name, str) and name not in robot_files() | scene_files():
            try:
                beside = folder / name
                part[key] = str(beside) if beside.exists() else name
            except (OSError, ValueError):  # a name too long, a null character
                continue
    return data


def make_scenario(data: object, file: str | Path = "scenario") -> Scenario:
    """Return the scenario that plain data describes; each value is checked by itself.

    Whether they fit each other, robot and scene, `validate` checks.

    Raises:
        ScenarioError: the data has unknown fields or values that are not allowed.
    """
    return check(data, Scenario, file, together=False)


def parse_scenario(text: str, file: str | Path = "scenario") -> Scenario:
    """Return the scenario that a YAML text describes, see `make_scenario`.

    Raises:
        ScenarioError: the text is no YAML, has unknown fields or values that are not allowed.
    """
    return make_scenario(load_yaml(text, file), file)


def scenario_data(scenario: Scenario) -> Any:
    """Return a scenario as plain data; `make_scenario` gives back an equal one.

    It has every field but the defaults that wait for the size of a robot; in the scenario of a
    loop, or of a run, no number does.
    """
    return _without_size(plain(scenario))


def dump_scenario(scenario: Scenario) -> str:
    """Return `scenario_data` as YAML; `parse_scenario` gives back an equal scenario."""
    data = scenario_data(scenario)
    return yaml.dump(data, Dumper=_Dumper, sort_keys=False, allow_unicode=True)


def _without_size(data: Any) -> Any:
    """Return plain data without the numbers that wait for the size of a robot."""
    if isinstance(data, dict):
        return {key: _without_size(value) for key, value in data.items() if not _waits(value)}
    return [_without_size(item) for item in data] if isinstance(data, list) else data


def _waits(value: Any) -> bool:
    return isinstance(value[0] if isinstance(value, list) and value else value, ScaledDefault)


def validate(scenario: Scenario, file: str | Path = "scenario") -> Scenario:
    """Check a scenario without building anything, wherever its values have come from.

    Returns:
        An equal one, with lists where tuples or arrays were given.

    Raises:
        ScenarioError: a field is not usable; the message names it and what is allowed.
    """
    scenario = check(plain(scenario), Scenario, file)
    scene_of(scenario, file)

    def read(robot: Path) -> HumanoidDescription:
        return load_description(robot_file(robot))

    check_limits(scenario, read_part("robot", scenario.robot, robot_files(), read, file), file)
    return scenario


def check_limits(
    scenario: Scenario, robot: HumanoidDescription, file: str | Path = "scenario"
) -> None:
    """Check the gait against the limits of a robot, but for defaults that have no size yet.

    Raises:
        ScenarioError: the gait stands too high, too low, too wide or too narrow.
    """
    limits, gait = robot.limits, scenario.gait
    for name, value, low, high in (
        ("step_width", gait.step_width, limits.step_width_min, limits.step_width_max),
        ("com_height", gait.com_height, limits.com_height_min, limits.com_height_max),
    ):
        if not (isinstance(value, ScaledDefault) or low <= value <= high):
            allowed = f"must lie in [{low}, {high}], the limits of {robot.name}"
            raise ScenarioError(file, f"gait.{name}", value, allowed)
