"""Scenarios in and out of YAML, with errors that name file, field, value and what is allowed."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml
from pydrake.common.yaml import yaml_dump_typed, yaml_load_typed

from drake_linefoot.errors import ScenarioError
from drake_linefoot.resources import diagrams_dir
from drake_linefoot.scenario import Scenario
from drake_linefoot.scenario_rules import check_rules
from drake_linefoot.scenario_types import check_types, fields_of, shown

_NOTHING = object()  # not None, which is a value


def shipped_scenarios() -> list[str]:
    """Return the names of the scenarios that come with the package."""
    return sorted(path.stem for path in diagrams_dir().glob("*.yaml"))


def scenario_file(name_or_path: str | Path) -> Path:
    """Return the file of a scenario; a shipped name goes before a path.

    Raises:
        ScenarioError: it is neither a shipped name nor the path of a file.
    """
    name = str(name_or_path)
    if name in shipped_scenarios():
        return diagrams_dir() / f"{name}.yaml"
    path = Path(name)
    try:
        exists, folder = path.exists(), path.is_dir()
    except (OSError, ValueError):  # a name too long, a null character
        exists, folder = False, False
    if folder:
        raise ScenarioError("scenario", "", shown(name), "is a folder; must be a YAML file")
    if not exists:
        allowed = f"no such file; must be one of {shipped_scenarios()}, or the path of a YAML file"
        raise ScenarioError("scenario", "", shown(name), allowed)
    return path


def load_scenario(
    name_or_path: str | Path, overrides: Mapping[str, object] | None = None
) -> Scenario:
    """Read and check a scenario; what the file does not name keeps its default.

    Args:
        name_or_path: a shipped name (`shipped_scenarios`), or the path of a YAML file.
        overrides: dotted field -> value, for instance ``{"mpc.model": "srbm", "seed": 3}`` or
            ``{"pushes[0].time": 2.0}``; they take the place of what the file says.

    Returns:
        The scenario.

    Raises:
        ScenarioError: there is no such file, it is no YAML, or it is no scenario.
    """
    file = scenario_file(name_or_path)
    scenario = parse_scenario(_read(file, "scenario"), file)
    for entry, value in (overrides or {}).items():
        _override(scenario, entry, value, file)
    validate(scenario, file)
    return scenario


def parse_scenario(text: str, file: str | Path = "scenario") -> Scenario:
    """Return the scenario that a YAML text describes; types are checked, values are not.

    Args:
        text: the YAML.
        file: what errors call it.

    Raises:
        ScenarioError: the text is no YAML, has unknown fields or values of a wrong type.
    """
    check_types(load_yaml(text, file), Scenario, file)
    scenario: Scenario = yaml_load_typed(schema=Scenario, data=text)
    return scenario


def dump_scenario(scenario: Scenario) -> str:
    """Return a scenario as YAML with every field; `parse_scenario` gives back an equal one."""
    data = yaml.safe_load(yaml_dump_typed(scenario))  # which leaves out what is None
    _add_nothing(data, scenario)
    text: str = yaml.safe_dump(data, sort_keys=False, allow_unicode=True)
    return text


def validate(scenario: Scenario, file: str | Path = "scenario") -> None:
    """Check types and values of a scenario without building anything.

    Args:
        scenario: what to check.
        file: what errors call it.

    Raises:
        ScenarioError: a field is not usable; the message names it and what is allowed.
    """
    check_types(fields_of(scenario), Scenario, file)
    check_rules(scenario, file)


def _override(scenario: Scenario, entry: str, value: object, file: Path) -> None:
    """Set one dotted field; `pushes[0].impulse` is that of the first push."""
    *parents, last = re.sub(r"\[(\d+)\]", r".\1", entry).split(".")
    target: Any = scenario
    for name in parents:
        target = _part(target, name)
    if _part(target, last) is _NOTHING:
        raise ScenarioError(file, entry, shown(value), "no such field")
    if isinstance(target, list):
        target[int(last)] = value
    else:
        setattr(target, last, value)


def _part(whole: Any, name: str) -> Any:
    """Return a field by name, or an item of a list by number; `_NOTHING` when there is none."""
    if isinstance(whole, list):
        return whole[int(name)] if name.isdecimal() and int(name) < len(whole) else _NOTHING
    return getattr(whole, name, _NOTHING)


def _add_nothing(data: dict[str, Any], part: Any) -> None:
    """Add the fields of a dataclass that are None to its plain data, in their order."""
    for field in dataclasses.fields(part):
        value = getattr(part, field.name)
        data[field.name] = data.pop(field.name, None)
        if dataclasses.is_dataclass(value):
            _add_nothing(data[field.name], value)


def _read(file: Path, what: str) -> str:
    """Return the text of a file, of which errors say `what` it should have been."""
    try:
        return file.read_text(encoding="utf-8")
    except (OSError, ValueError) as error:  # no permission; not UTF-8
        reason = getattr(error, "strerror", None) or "is not UTF-8 text"
        raise ScenarioError(file, "", what, f"cannot be read: {reason}") from error


def read_yaml(file: Path, what: str = "scenario") -> Any:
    """Return what a YAML file says, in plain Python types.

    Args:
        file: the file.
        what: it should hold, for the message of an error.

    Raises:
        ScenarioError: it cannot be read, or is no YAML.
    """
    return load_yaml(_read(file, what), file)


def load_yaml(text: str, file: str | Path) -> Any:
    """Return what a YAML text says, in plain Python types.

    Raises:
        ScenarioError: the text is no YAML, or gives a key twice.
    """
    try:
        return yaml.load(text, Loader=_Loader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        where = f"line {mark.line + 1}" if mark else ""
        line = text.splitlines()[mark.line].strip() if mark and _has_line(text, mark.line) else ""
        reason = " ".join((error.problem or error.context or "").split())
        raise ScenarioError(file, where, shown(line), f"is no YAML: {reason}") from error
    except Exception as error:  # PyYAML raises all kinds for odd text; RecursionError as well
        reason = " ".join(str(error).split())
        raise ScenarioError(file, "", "scenario", f"is no YAML: {reason}") from error


def _has_line(text: str, line: int) -> bool:
    return line < len(text.splitlines())


class _Loader(yaml.SafeLoader):
    """A SafeLoader that refuses a key given twice, of which YAML would drop the first."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        seen = set()
        for key, _ in node.value:
            if isinstance(key, yaml.ScalarNode):
                if key.value in seen:
                    problem = f"{key.value!r} is given twice"
                    raise yaml.constructor.ConstructorError(None, None, problem, key.start_mark)
                seen.add(key.value)
        return super().construct_mapping(node, deep)
