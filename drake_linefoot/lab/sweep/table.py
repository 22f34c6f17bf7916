"""The results as a Parquet table: one row a run, units in the metadata of the columns."""

import io
import json
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import pyarrow.parquet

from drake_linefoot.errors import InputError
from drake_linefoot.files import write_file
from drake_linefoot.lab.results.judge import OUTCOME, Column
from drake_linefoot.lab.sweep.rows import COLUMNS, RUN, WORK, Row, problem_of

PARQUET = "runs.parquet"


def write_table(
    path: Path, rows: Sequence[Row], units: Mapping[str, str], about: dict[str, Any]
) -> None:
    """Write the table: all of it, or on an error nothing.

    Args:
        path: of the file.
        rows: in their order.
        units: of the sampled values, by dotted path; the columns of these names follow `RUN`.
        about: goes into the metadata of the table.

    Raises:
        OutputError: it cannot be written.
    """
    content = io.BytesIO()
    pyarrow.parquet.write_table(table(rows, units, about), content)
    write_file(path, content.getvalue())


def table(rows: Sequence[Row], units: Mapping[str, str], about: dict[str, Any]) -> pyarrow.Table:
    """Return the table; see `write_table`. What a group does not sample is null in its rows."""
    sampled = {
        path: column([row["sampled"].get(path) for row in rows])
        for path in units
        if path not in RUN
    }
    kinds = {path: Column(str(sampled[path].type), units[path], "sampled") for path in sampled}
    schema = pyarrow.schema(
        [_field(*item) for item in {**RUN, **kinds, **OUTCOME, **WORK}.items()],
        metadata={"linefoot": json.dumps(about)},
    )
    others = {name: [row[name] for row in rows] for name in COLUMNS}
    return pyarrow.table(others | sampled, schema=schema)


def read_table(path: Path) -> tuple[list[Row], dict[str, str], dict[str, Any]]:
    """Read what `write_table` wrote.

    Returns:
        The rows, the units of the sampled values by dotted path, and what is about the table. A
        row has no value of what its group does not sample.

    Raises:
        InputError: it cannot be read, or is no such table.
    """
    try:
        found = pyarrow.parquet.read_table(path)
        about = json.loads(found.schema.metadata[b"linefoot"])
    except (OSError, pyarrow.ArrowException, KeyError, TypeError, ValueError) as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError(path, "", "table", f"cannot be read: {reason}") from error
    fields = [field for field in found.schema if field.name not in COLUMNS]
    units = {field.name: field.metadata[b"unit"].decode() for field in fields}
    rows = []
    for row in found.to_pylist():
        sampled = {path: row[path] for path in units if row[path] is not None}
        rows.append({**{name: row.get(name) for name in COLUMNS}, "sampled": sampled})
        if problem := problem_of(rows[-1]):
            raise InputError(path, "", "table", f"is damaged: {problem}")
    return rows, units, about


def column(values: Sequence[Any]) -> pyarrow.Array:
    """Return sampled values as one column can hold them: numbers, flags or else text."""
    with suppress(pyarrow.ArrowException):
        made = pyarrow.array(values)
        if pyarrow.types.is_primitive(made.type):
            return made
    texts = [v if v is None or isinstance(v, str) else json.dumps(v) for v in values]
    return pyarrow.array(texts, pyarrow.string())


def _field(name: str, column: Column) -> pyarrow.Field:
    metadata = {"unit": column.unit, "what": column.what}
    return pyarrow.field(name, pyarrow.type_for_alias(column.kind), metadata=metadata)
