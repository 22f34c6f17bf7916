"""YAML files in plain Python types, with errors that name file and line."""

from pathlib import Path
from typing import Any

import yaml

from drake_linefoot.checks import shown
from drake_linefoot.errors import InputError, ScenarioError


def read_yaml(file: Path, what: str, error: type[InputError] = ScenarioError) -> Any:
    """Return what a YAML file says, in plain Python types.

    Args:
        file: the file.
        what: it should hold, for the message of an error.
        error: what is raised.

    Raises:
        InputError: it cannot be read, or is no YAML, or gives a key twice; an `error`.
    """
    try:
        text = file.read_text(encoding="utf-8")
    except (OSError, ValueError) as wrong:  # no permission, a null character; not UTF-8
        reason = getattr(wrong, "strerror", None) or "is not UTF-8 text, as YAML is"
        raise error(file, "", what, f"cannot be read: {reason}") from wrong
    return load_yaml(text, file, what, error)


def load_yaml(
    text: str, file: str | Path, what: str = "scenario", error: type[InputError] = ScenarioError
) -> Any:
    """Return what a YAML text says, in plain Python types.

    An outermost key that begins with "_" is a place for anchors and left out, as Drake does.

    Args:
        text: the YAML.
        file: what errors call it.
        what: it should hold, for the message of an error.
        error: what is raised.

    Raises:
        InputError: the text is no YAML, or gives a key twice; an `error`.
    """
    try:
        data = yaml.load(text, Loader=_Loader)
    except yaml.MarkedYAMLError as wrong:
        mark = wrong.problem_mark or wrong.context_mark
        where, lines = f"line {mark.line + 1}" if mark else "", text.splitlines()
        line = lines[mark.line].strip() if mark and mark.line < len(lines) else ""
        reason = " ".join((wrong.problem or wrong.context or "").split())
        raise error(file, where, shown(line), f"is no YAML: {reason}") from wrong
    except Exception as wrong:  # PyYAML raises all kinds for odd text; RecursionError as well
        reason = " ".join(str(wrong).split())
        raise error(file, "", what, f"is no YAML: {reason}") from wrong
    if isinstance(data, dict):
        return {key: value for key, value in data.items() if not str(key).startswith("_")}
    return data


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
