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
from drake_linefoot.lab.sweep.rows import OUTCOME, RUN, WORK, Column, Row

PARQUET = "runs.parquet"


def write_table(
    path: Path, rows: Sequence[Row], units: Mapping[str, str], about: dict[str, Any]
) -> None:
    """Write the table: all of it, or on an error nothing.

    Args:
        path: of the file.
        rows: in their order.
        units: of what is drawn, by dotted path; the columns of these names follow `RUN`.
        about: goes into the metadata of the table.

    Raises:
        OutputError: it cannot be written.
    """
    content = io.BytesIO()
    pyarrow.parquet.write_table(table(rows, units, about), content)
    write_file(path, content.getvalue())


def table(rows: Sequence[Row], units: Mapping[str, str], about: dict[str, Any]) -> pyarrow.Table:
    """Return the table; see `write_table`. What a group does not draw is null in its rows."""
    drawn = {
        path: column([row["sampled"].get(path) for row in rows])
        for path in units
        if path not in RUN
    }
    kinds = {path: Column(str(drawn[path].type), units[path], "drawn") for path in drawn}
    schema = pyarrow.schema(
        [_field(*item) for item in {**RUN, **kinds, **OUTCOME, **WORK}.items()],
        metadata={"linefoot": json.dumps(about)},
    )
    others = {name: [row[name] for row in rows] for name in (*RUN, *OUTCOME, *WORK)}
    return pyarrow.table(others | drawn, schema=schema)


def read_table(path: Path) -> tuple[list[Row], dict[str, str], dict[str, Any]]:
    """Read what `write_table` wrote.

    Returns:
        The rows, the units of what was drawn by dotted path, and what is about the table. What a
        row has no value for was not drawn in its group.

    Raises:
        InputError: it cannot be read, or is no such table.
    """
    try:
        found = pyarrow.parquet.read_table(path)
        about = json.loads(found.schema.metadata[b"linefoot"])
    except (OSError, pyarrow.ArrowException, KeyError, TypeError, ValueError) as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError(path, "", "table", f"cannot be read: {reason}") from error
    known = {**RUN, **OUTCOME, **WORK}
    drawn = [field for field in found.schema if field.name not in known]
    units = {field.name: field.metadata[b"unit"].decode() for field in drawn}
    rows = []
    for row in found.to_pylist():
        sampled = {path: row[path] for path in units if row[path] is not None}
        rows.append({**{name: row.get(name) for name in known}, "sampled": sampled})
    return rows, units, about


def column(values: Sequence[Any]) -> pyarrow.Array:
    """Return drawn values as one column can hold them: numbers, flags or else text."""
    with suppress(pyarrow.ArrowException):
        made = pyarrow.array(values)
        if pyarrow.types.is_primitive(made.type):
            return made
    texts = [v if v is None or isinstance(v, str) else json.dumps(v) for v in values]
    return pyarrow.array(texts, pyarrow.string())


def _field(name: str, column: Column) -> pyarrow.Field:
    metadata = {"unit": column.unit, "what": column.what}
    return pyarrow.field(name, pyarrow.type_for_alias(column.kind), metadata=metadata)
