"""Units of a scenario's entries, read from the comments beside its fields."""

from __future__ import annotations

import ast
import dataclasses
import inspect
import re
import textwrap
from functools import cache
from typing import Any, get_args, get_type_hints

from drake_linefoot.scenario import Scenario
from drake_linefoot.sweep.entries import parts_of

NONE = "-"
_UNIT = re.compile(r"#\s*\[([^\]]+)\]")


def unit_of(path: str) -> str:
    """Return the unit of an entry of a scenario by its dotted path; "-" where none is written."""
    kind: Any = Scenario
    unit = NONE
    for part in parts_of(path):
        if isinstance(part, int):
            (kind,) = get_args(kind)[:1] or (None,)
            continue
        fields = [k for k in (kind, *get_args(kind)) if dataclasses.is_dataclass(k)]
        if not fields:
            return NONE
        owner = fields[0]
        unit = _units(owner).get(part, NONE)  # type: ignore[arg-type]
        kind = get_type_hints(owner).get(part)
    return unit


@cache
def _units(kind: type) -> dict[str, str]:
    """Return the units of a dataclass by the names of its fields."""
    source = textwrap.dedent(inspect.getsource(kind))
    lines = source.splitlines()
    (body,) = ast.parse(source).body
    found = {}
    for node in ast.walk(body):
        if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            unit = _UNIT.search(lines[(node.end_lineno or node.lineno) - 1])
            if unit:
                found[node.target.id] = unit.group(1)
    return found
