"""Entries of a scenario in plain data by their dotted paths: `segments[1].velocity[0]`."""

import re
from functools import reduce
from operator import getitem
from typing import Any

_NAME, _INDEX = r"([A-Za-z_]\w*)", r"\[(\d+)\]"
_PATH = re.compile(rf"{_NAME}(\.{_NAME}|{_INDEX})*")


def parts_of(path: str) -> tuple[str | int, ...]:
    """Return the names and list indices of a dotted path.

    Raises:
        KeyError: it is no such path.
    """
    if not _PATH.fullmatch(path):
        raise KeyError(path)
    return tuple(name or int(index) for name, index in re.findall(f"{_NAME}|{_INDEX}", path))


def get(data: Any, path: str) -> Any:
    """Return the value at a dotted path.

    Raises:
        KeyError: there is none.
    """
    for part in parts_of(path):
        is_field = isinstance(part, str) and isinstance(data, dict) and part in data
        is_item = isinstance(part, int) and isinstance(data, list) and part < len(data)
        if not (is_field or is_item):
            raise KeyError(path)
        data = data[part]
    return data


def put(data: Any, path: str, value: object) -> None:
    """Replace the value at a dotted path, in place.

    Raises:
        KeyError: there is none.
    """
    get(data, path)
    *parents, last = parts_of(path)
    reduce(getitem, parents, data)[last] = value
