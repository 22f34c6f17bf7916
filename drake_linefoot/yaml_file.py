"""YAML files in plain Python types, with errors that name file and line.

What takes long or much memory to read is refused: files too large, nested too deeply, or with
aliases and merges that stand for too much.
"""

import copy
from functools import lru_cache
from pathlib import Path
from typing import Any

import yaml

from drake_linefoot.checks import shown
from drake_linefoot.errors import InputError, ScenarioError, legible
from drake_linefoot.files import read_file

LARGEST = 2**19  # bytes of a file
DEEPEST = 50  # levels of lists and mappings
MOST_NODES = 75_000  # with what aliases stand for; two seconds to read
LONGEST_NUMBER = 10_000  # digits
_LONGEST_REASON = 120  # characters
_NUMBERS = ("tag:yaml.org,2002:int", "tag:yaml.org,2002:float")


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
        text = read_file(file, LARGEST).decode("utf-8")
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
        data = copy.deepcopy(_loaded(text))
    except yaml.MarkedYAMLError as wrong:
        mark = wrong.problem_mark or wrong.context_mark
        where, lines = f"line {mark.line + 1}" if mark else "", text.splitlines()
        line = lines[mark.line].strip() if mark and mark.line < len(lines) else ""
        reason = _reason(wrong.problem or wrong.context)
        raise error(file, where, shown(line), f"is no YAML: {reason}") from wrong
    except Exception as wrong:  # PyYAML raises all kinds for odd text; RecursionError as well
        reason = _reason(wrong)
        raise error(file, "", what, f"is no YAML: {reason}") from wrong
    if isinstance(data, dict):
        return {key: value for key, value in data.items() if not str(key).startswith("_")}
    return data


@lru_cache(maxsize=32)  # robots and scenes are asked for again and again
def _loaded(text: str) -> Any:
    return yaml.load(text, Loader=_Loader)


def _reason(problem: object) -> str:
    return legible(str(problem or ""), _LONGEST_REASON)


class _Loader(yaml.SafeLoader):
    """A SafeLoader that refuses bombs, and a key given twice, of which YAML drops the first."""

    def __init__(self, text: str) -> None:
        super().__init__(text)
        self._depth = 0
        self._sizes: dict[int, int] = {}  # of each node, with what aliases in it stand for

    def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
        """Compose a node, and count what it stands for."""
        mark = self.peek_event().start_mark
        self._depth += 1
        if self._depth > DEEPEST:
            raise yaml.composer.ComposerError(None, None, "is nested too deeply", mark)
        is_alias = self.check_event(yaml.AliasEvent)
        node = super().compose_node(parent, index)
        self._depth -= 1
        if node is not None and not is_alias:
            inner = node.value if isinstance(node, yaml.CollectionNode) else []
            if isinstance(node, yaml.MappingNode):
                inner = [part for pair in node.value for part in pair]
            size = self._sizes[id(node)] = 1 + sum(self._sizes.get(id(part), 1) for part in inner)
            if size > MOST_NODES:
                raise yaml.composer.ComposerError(None, None, "stands for too much", mark)
        return node

    def construct_scalar(self, node: yaml.ScalarNode | yaml.MappingNode) -> Any:
        """Return the text of a scalar; numbers of many digits take long to convert."""
        text = super().construct_scalar(node)
        if node.tag in _NUMBERS and len(text) > LONGEST_NUMBER:
            problem = f"is a number of {len(text)} digits"
            raise yaml.constructor.ConstructorError(None, None, problem, node.start_mark)
        return text

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        seen = set()
        for key, _ in node.value:
            if isinstance(key, yaml.ScalarNode):
                if key.value in seen:
                    problem = f"{shown(key.value)!r} is given twice"
                    raise yaml.constructor.ConstructorError(None, None, problem, key.start_mark)
                seen.add(key.value)
        return super().construct_mapping(node, deep)
