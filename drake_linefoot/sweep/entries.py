"""Entries of a scenario by their dotted path, in plain data: `segments[1].velocity[0]`."""

from __future__ import annotations

import re
from typing import Any

_PART = re.compile(r"\.?([A-Za-z_]\w*)|\[(\d+)\]")


def parts_of(path: str) -> tuple[str | int, ...]:
    """Return the names and list indices of a dotted path.

    Raises:
        KeyError: it is no such path.
    """
    parts: list[str | int] = []
    at = 0
    while at < len(path):
        found = _PART.match(path, at)
        if found is None or (at == 0) != (path[found.start()] not in ".["):
            raise KeyError(path)
        name, index = found.groups()
        parts.append(name if index is None else int(index))
        at = found.end()
    if not parts:
        raise KeyError(path)
    return tuple(parts)


def get(data: Any, path: str) -> Any:
    """Return the value at a dotted path.

    Raises:
        KeyError: there is none.
    """
    for part in parts_of(path):
        data = _step(data, part, path)
    return data


def put(data: Any, path: str, value: object) -> None:
    """Replace the value at a dotted path, in place.

    Raises:
        KeyError: there is none.
    """
    *parents, last = parts_of(path)
    for part in parents:
        data = _step(data, part, path)
    _step(data, last, path)
    data[last] = value


def _step(data: Any, part: str | int, path: str) -> Any:
    """Return what a mapping or a list holds under a name or an index."""
    if isinstance(part, str) and isinstance(data, dict) and part in data:
        return data[part]
    if isinstance(part, int) and isinstance(data, list) and part < len(data):
        return data[part]
    raise KeyError(path)
