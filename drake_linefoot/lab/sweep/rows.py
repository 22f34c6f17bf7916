"""A row of the results: run, sampled parameters, outcome, and how it was done."""

import math
from typing import Any

from drake_linefoot.errors import legible
from drake_linefoot.lab.results.judge import OUTCOME, Column
from drake_linefoot.lab.sweep.jobs import Job, Key

Row = dict[str, Any]
Made = tuple[Row, dict[str, str]]  # a row, and what it was made with

RUN = {
    "group": Column("string", "-", "the case"),
    "index": Column("int64", "-", "of the run within its group"),
    "seed": Column("int64", "-", "of the scenario"),
}
WORK = {
    "error": Column("string", "-", "why the run has no outcome; empty when it has one"),
    "attempts": Column("int64", "-", "times it was begun: 2 when a worker died under the first"),
    "wall_seconds": Column("double", "s", "to build and simulate it"),
    "worker_mb": Column("double", "MB", "resident memory of its worker after it"),
    "worker": Column("string", "-", "host and process of its worker"),
}
COLUMNS = {**RUN, **OUTCOME, **WORK}
REQUIRED = (*RUN, "cause", "error", "attempts", "worker")  # None stands in the others at most
FAILED = {"cause": "error"}  # outcome of a run without one
_TYPES = {"string": str, "int64": int, "double": float, "bool": bool}
_NAMES = {
    "string": "a text",
    "int64": "a whole number",
    "double": "a number",
    "bool": "a flag",
}


def row_of(job: Job, outcome: dict[str, Any], work: dict[str, Any]) -> Row:
    """Return the row of a run; `work` is what `WORK` lists, as far as it is known."""
    return {
        **{"group": job.group, "index": job.index, "seed": job.seed, "sampled": job.sampled},
        **{name: outcome.get(name) for name in OUTCOME},
        **{"error": "", "attempts": 1, "wall_seconds": None, "worker_mb": None, "worker": ""},
        **work,
    }


def key_of(row: Row) -> Key:
    """Return which run a row is of."""
    return str(row["group"]), int(row["index"])


def problem_of(row: Row) -> str:
    """Return what is wrong with a row, naming run and field; empty when it is one."""
    where = legible(f"run {str(row.get('index'))[:40]} of {row.get('group')}")
    if not isinstance(row.get("sampled"), dict):
        return f"{where}: sampled must be values by dotted path"
    for name, column in COLUMNS.items():
        value, kind = row.get(name), _TYPES[column.kind]
        if value is None:
            if name in REQUIRED or name not in row:
                return f"{where}: {name} is missing"
            continue
        fits = type(value) is kind or (kind is float and type(value) is int)
        if not fits or (kind is not str and not _is_finite(value, kind)):
            return f"{where}: {name} = {str(value)[:40]!r} must be {_NAMES[column.kind]}"
    if (row["fell"] is True) != (row["fall_time"] is not None):  # as in a recording
        found = repr(row["fall_time"])[:40]
        return f"{where}: fall_time = {found} must be there for a fall, and for nothing else"
    return ""


def _is_finite(value: float, kind: type) -> bool:
    """Return whether a column of numbers of a kind can hold it; a double holds 53 bits."""
    bits = 53 if kind is float else 63
    return abs(value) < 2**bits if isinstance(value, int) else math.isfinite(value)
