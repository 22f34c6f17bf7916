"""Holds values against what `drake_linefoot.fields` declares, and says what is wrong in a line."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from difflib import get_close_matches
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from pydantic import TypeAdapter, ValidationError

from drake_linefoot.errors import InputError, ScenarioError
from drake_linefoot.fields import (
    ALONE,
    MISFIT,
    NO_UNIT,
    RENAMED,
    ScaledDefault,
    declared_at,
    unit_of,
)

Kind = TypeVar("Kind")
_LONGEST = 60  # characters of a value in a message
_NAMED = 40  # fields at most that a message names
_LARGEST_BITS = 63  # of a number that is shown
_NO_UNKNOWN_FIELDS = {"extra": "forbid"}
_BOUNDS = {"gt", "ge", "lt", "le"}
_UNKNOWN = ("unexpected_keyword_argument", "invalid_key")


def check(
    data: Any,
    kind: type[Kind],
    file: str | Path,
    at: Sequence[str] = (),
    error: type[InputError] = ScenarioError,
    *,
    together: bool = True,
) -> Kind:
    """Return a dataclass made of plain data, each field as it is declared.

    Args:
        data: mappings, lists and scalars, as YAML gives them or `plain` makes them.
        kind: the dataclass; fields that `data` does not name keep their defaults.
        file: what errors call the source.
        at: path of `data` within it.
        error: what is raised.
        together: whether fields must fit each other as well.

    Raises:
        InputError: a field is not usable; the first one, as an `error`.
    """
    try:
        adapter: TypeAdapter[Kind] = _adapter(kind)  # type: ignore[arg-type]  # a class is hashable
        made = adapter.validate_python(data, context=None if together else ALONE)
    except ValidationError as problems:
        wrong = problems.errors(include_url=False)[0]
        path, value = _found(wrong, kind, data)
        allowed = _allowed(wrong, kind, path)
        wrong_one = error(file, _label([*at, *path]), shown(value), allowed)
        raise wrong_one from None  # of thousands, the others would be printed as its cause
    return made


def plain(value: Any) -> Any:
    """Return a dataclass as plain data, with whatever attributes have been set on it.

    Tuples and arrays become lists, numbers of numpy's those of Python.
    """
    if is_dataclass(value):
        return {name: plain(inner) for name, inner in vars(value).items()}
    if isinstance(value, Mapping):
        return {name: plain(inner) for name, inner in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if not isinstance(value, float) or isinstance(value, ScaledDefault):
        return value
    return float(value)


def shown(value: object) -> object:
    """Return a value as a message shows it: itself, unless it is long."""
    if isinstance(value, int) and value.bit_length() > _LARGEST_BITS:
        return f"a whole number of {value.bit_length()} bits"
    if isinstance(value, str):
        return value if len(value) <= _LONGEST else value[:_LONGEST] + "..."
    if isinstance(value, list) and len(value) <= 6 and all(map(_is_short, value)):
        return value
    if isinstance(value, list | dict | set | tuple | bytes):
        return f"a {type(value).__name__} of {len(value)}"
    if len(text := repr(value)) <= _LONGEST and text.isprintable():
        return value
    return f"a {type(value).__name__}"


@cache
def _adapter(kind: Any) -> TypeAdapter[Any]:
    kind.__pydantic_config__ = _NO_UNKNOWN_FIELDS
    return TypeAdapter(kind)


def _found(wrong: Any, kind: Any, data: Any) -> tuple[list[Any], Any]:
    """Return the path of what is wrong in plain data, and its value."""
    path = [part for part in wrong["loc"] if part != "[key]"]
    if wrong["type"] == MISFIT:
        return [*path, wrong["ctx"]["entry"]], wrong["ctx"]["value"]
    if wrong["type"] == "missing":
        return path, None
    if wrong["type"] == "invalid_key":  # which pydantic shows in its own way
        for part in path[:-1]:
            data = data[part]
        key = next(key for key in data if not isinstance(key, str))
        return [*path[:-1], repr(key)], data[key]
    return path, wrong["input"]


def _nearest(path: Sequence[str | int], names: list[str]) -> str:
    """Return names of fields in a line: all, or those nearest to the end of a path of so many."""
    if len(names) <= _NAMED:
        return str(names)
    near = get_close_matches(str(path[-1]), names) or names[:3]
    return f"{near}, or another of {len(names)}"


def _allowed(wrong: Any, kind: Any, path: Sequence[str | int]) -> str:
    """Return what a field may hold, in pydantic's words or those of the rule that it broke."""
    context, words = wrong.get("ctx", {}), re.sub(r"^\w+ should ", "must ", wrong["msg"])
    if wrong["type"] in _UNKNOWN:
        names = sorted(field.name for field in fields(declared_at(kind, path[:-1])[0]))
        now = RENAMED.get(str(path[-1]))
        known = (
            f"is called {now} now" if now in names else f"must be one of {_nearest(path, names)}"
        )
        return f"unknown field; {known}"
    if wrong["type"] in (MISFIT, "value_error"):
        return str(context.get("allowed", context.get("error")))
    if wrong["type"] == "float_type" and isinstance(wrong["input"], str):
        is_number = _is_number(wrong["input"])
        return words + is_number * "; YAML takes 1e-3 and 1.0e3 for text, write 1.0e-3 and 1.0e+3"
    unit = unit_of(kind, path)
    return f"{words} {unit}" if _BOUNDS & context.keys() and unit != NO_UNIT else words


def _label(path: Sequence[Any]) -> str:
    """Return a dotted path; what is no name is shown as Python writes it."""
    label = ""
    for part in path:
        name = part if isinstance(part, str) and part.isprintable() else repr(part)
        is_index = isinstance(part, int)
        label += f"[{part}]" if is_index else f".{name}" if label else str(name)
    return str(shown(label))


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _is_short(value: object) -> bool:
    return isinstance(value, int | float | str) and shown(value) is value
