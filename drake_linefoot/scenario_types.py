"""The shape of a scenario: which fields there are, and the type of each.

Drake's YAML loader checks this too, but does not say where in the file it found something.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, get_args, get_origin

from drake_linefoot.errors import ScenarioError

_LONGEST = 60  # characters of a value in a message
_LARGEST_BITS = 63  # of a whole number
_KINDS = {
    int: "a whole number",
    float: "a number",
    bool: "true or false",
    str: "text",
    list: "a list",
    dict: "a mapping",
}


def shown(value: object) -> object:
    """Return a value as a message shows it: itself, unless it is long."""
    if isinstance(value, int) and value.bit_length() > _LARGEST_BITS:
        return f"a whole number of {value.bit_length()} bits"
    if isinstance(value, str) and len(value) > _LONGEST:
        return value[:_LONGEST] + "..."
    if isinstance(value, list) and len(value) <= 6 and all(_is_short(v) for v in value):
        return value
    if isinstance(value, list | dict | set | tuple | bytes):
        return f"a {type(value).__name__} of {len(value)}"
    return value


def check_types(data: Any, schema: type, file: str | Path, entry: str = "") -> None:
    """Check plain data (what YAML gives) against a dataclass.

    Args:
        data: mappings, lists and scalars.
        schema: the dataclass.
        file: what errors call the source.
        entry: dotted path of `data` within it.

    Raises:
        ScenarioError: an unknown field, or a value of a wrong type.
    """
    if not isinstance(data, dict):
        raise ScenarioError(file, entry, shown(data), "must be a mapping of fields")
    types = {field.name: field.type for field in dataclasses.fields(schema)}
    for name, value in data.items():
        label = name if isinstance(name, str) and name.isprintable() else repr(shown(name))
        at = f"{entry}.{label}" if entry else label
        if not entry and isinstance(name, str) and name.startswith("_"):
            continue  # Drake's rule: a place for YAML anchors
        if name not in types:
            allowed = f"unknown field; must be one of {sorted(types)}"
            raise ScenarioError(file, str(shown(at)), shown(value), allowed)
        _check_value(value, types[name], file, at)


def leaves(value: Any, entry: str = "") -> Iterator[tuple[str, Any]]:
    """Yield (dotted path, value) of every number, text and flag in a dataclass."""
    if dataclasses.is_dataclass(value):
        for field in dataclasses.fields(value):
            at = f"{entry}.{field.name}" if entry else field.name
            yield from leaves(getattr(value, field.name), at)
    elif isinstance(value, list):
        for i, item in enumerate(value):
            yield from leaves(item, f"{entry}[{i}]")
    else:
        yield entry, value


def fields_of(value: Any) -> Any:
    """Return a dataclass as plain data, without copying what is no dataclass or list."""
    if dataclasses.is_dataclass(value):
        return {f.name: fields_of(getattr(value, f.name)) for f in dataclasses.fields(value)}
    if isinstance(value, list):
        return [fields_of(item) for item in value]
    return value


def _check_value(value: Any, kind: Any, file: str | Path, at: str) -> None:
    """Check one value against the type of its field."""
    if isinstance(kind, UnionType):  # with None, which is nothing given
        if value is None:
            return
        (kind,) = (inner for inner in get_args(kind) if inner is not NoneType)
    if dataclasses.is_dataclass(kind) and isinstance(kind, type):
        check_types(value, kind, file, at)
        return
    plain = get_origin(kind) or kind
    fits = isinstance(value, plain)
    if plain in (int, float):
        fits = isinstance(value, int | plain) and not isinstance(value, bool)
    if not fits:
        allowed = f"must be {_KINDS[plain]}"
        if plain is float and isinstance(value, str) and _is_number(value):
            allowed += "; YAML takes 1e-3 for text, write 1.0e-3"
        raise ScenarioError(file, at, shown(value), allowed)
    if isinstance(value, int) and value.bit_length() > _LARGEST_BITS:
        allowed = f"must be {_KINDS[plain]} of at most {_LARGEST_BITS} bits"
        raise ScenarioError(file, at, shown(value), allowed)
    if plain is list:
        (inner,) = get_args(kind)
        for i, item in enumerate(value):
            _check_value(item, inner, file, f"{at}[{i}]")


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _is_short(value: object) -> bool:
    if isinstance(value, int) and value.bit_length() > _LARGEST_BITS:
        return False
    return isinstance(value, int | float) or (isinstance(value, str) and len(value) <= _LONGEST)
