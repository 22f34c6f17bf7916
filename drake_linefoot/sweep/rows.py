"""A row of the results: what makes the run, what it drew, what it came to, how it was done."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from drake_linefoot.sweep.jobs import Job, Key
from drake_linefoot.sweep.outcome import OUTCOME, Column

Row = dict[str, Any]

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
    "worker": Column("string", "-", "address of its worker"),
}
# The same in every repetition on machines of one kind: all but how the work was done.
REPEATABLE = (*RUN, *OUTCOME, "error")


def done_row(job: Job, outcome: dict[str, Any], work: dict[str, Any]) -> Row:
    """Return the row of a run; `work` is what `WORK` lists, as far as it is known."""
    how = {"error": "", "attempts": 1, "wall_seconds": None, "worker_mb": None, "worker": ""}
    return {
        **{"group": job.group, "index": job.index, "seed": job.seed},
        **{"sampled": job.sampled},
        **{name: outcome.get(name) for name in OUTCOME},
        **how,
        **work,
    }


def failed_row(job: Job, error: str, work: dict[str, Any]) -> Row:
    """Return the row of a run that has no outcome, and why."""
    return done_row(job, {"cause": "error"}, {**work, "error": error})


def key_of(row: Row) -> Key:
    """Return which run a row is of."""
    return str(row["group"]), int(row["index"])


def in_order(rows: Iterable[Row], groups: Iterable[str]) -> list[Row]:
    """Return rows by group, then by index."""
    places = {name: i for i, name in enumerate(groups)}
    return sorted(rows, key=lambda row: (places[row["group"]], row["index"]))


def upright(row: Row) -> bool:
    """Return whether a run succeeded: one without an outcome did not."""
    return row["fell"] is False and not row["error"]
