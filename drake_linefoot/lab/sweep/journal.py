"""The journal of a sweep, an SQLite file: each run is on the disk before the next one counts.

It is what a sweep that was killed goes on from. It can be read while it grows.
"""

import fcntl
import json
import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

from drake_linefoot.errors import InputError, OutputError
from drake_linefoot.files import writing
from drake_linefoot.lab.results.provenance import differences
from drake_linefoot.lab.sweep.rows import COLUMNS, RUN, Row, problem_of

JOURNAL, OLDER, LOCK = "journal.sqlite", "journal.jsonl", ".lock"
PATIENCE = 60.0  # [s] for a reader to end
ANOTHER = "name another --out, or --fresh"
_TYPES = {"string": "TEXT", "int64": "INTEGER", "double": "REAL", "bool": "INTEGER"}
_KINDS = {name: _TYPES[column.kind] for name, column in COLUMNS.items()} | {"sampled": "TEXT"}
_FIELDS = ", ".join(f'"{name}" {kind}' for name, kind in _KINDS.items())
_CREATE = f"""BEGIN;
CREATE TABLE sweep (name TEXT, fingerprint TEXT, made_with TEXT) STRICT;
CREATE TABLE runs ({_FIELDS}, PRIMARY KEY ("group", "index")) STRICT;
"""
_ADD = f"""INSERT INTO runs VALUES ({", ".join(f":{name}" for name in _KINDS)})
ON CONFLICT DO UPDATE SET {", ".join(f'"{n}" = excluded."{n}"' for n in _KINDS if n not in RUN)}
WHERE runs.error <> ''"""


class Journal:
    """An open journal."""

    def __init__(self, path: Path, file: sqlite3.Connection) -> None:
        """Use the open `file` at `path`."""
        self._path, self._file = path, file

    def rows(self) -> list[Row]:
        """Return the rows, group by group, by their index.

        Raises:
            InputError: the journal is damaged.
        """
        with _reading(self._path):
            names = [column[1] for column in self._file.execute("PRAGMA table_info(runs)")]
            found = self._file.execute('SELECT * FROM runs ORDER BY "group", "index"').fetchall()
            return [_row(dict(zip(names, values, strict=True))) for values in found]

    def add(self, row: Row) -> bool:
        """Write a row so that it survives the process; return False when its run has an outcome.

        Raises:
            OutputError: it cannot be written; the journal is what it was.
        """
        values = {**row, "sampled": json.dumps(row["sampled"], allow_nan=False)}
        try:
            return self._file.execute(_ADD, values).rowcount > 0
        except sqlite3.Error as error:
            raise OutputError(self._path, str(error)) from error


@contextmanager
def open_journal(folder: Path, header: dict[str, Any], fresh: bool) -> Iterator[Journal]:
    """Open the journal of a folder, and keep other processes from writing to it.

    Args:
        folder: exists.
        header: `name`, `fingerprint` and `made_with`, which an older journal must have as well.
        fresh: begin anew.

    Raises:
        InputError: it is the journal of something else, or damaged.
        OutputError: it cannot be written, or another process writes to it.
    """
    path, older = folder / JOURNAL, folder / OLDER
    with writing(path):
        lock = (folder / LOCK).open("ab")
    with lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            raise OutputError(path, "another sweep is writing to it") from error
        if fresh:
            for old in (older, path, path.with_name(f"{JOURNAL}-journal")):
                with writing(old):
                    old.unlink(missing_ok=True)
        elif older.exists():
            raise InputError(older, "", "journal", f"is of an older version; {ANOTHER}")
        try:
            file = sqlite3.connect(path, timeout=PATIENCE, isolation_level=None)
        except sqlite3.Error as error:
            raise OutputError(path, str(error)) from error
        with closing(file):
            _begin(path, file, header)
            yield Journal(path, file)


def _begin(path: Path, file: sqlite3.Connection, header: dict[str, Any]) -> None:
    """Make the tables where there are none, or check those that there are."""
    with _reading(path):
        tables = {name for (name,) in file.execute("SELECT name FROM sqlite_schema")}
    if not tables:
        values = [header["name"], header["fingerprint"], json.dumps(header["made_with"])]
        try:
            file.executescript(_CREATE)
            file.execute("INSERT INTO sweep VALUES (?, ?, ?)", values)
            file.execute("COMMIT")
        except sqlite3.Error as error:
            raise OutputError(path, str(error)) from error
        return
    with _reading(path):
        if (("ok",),) != (found := tuple(file.execute("PRAGMA quick_check(1)"))):
            raise ValueError(found[0][0])
        ((name, fingerprint, made_with),) = file.execute("SELECT * FROM sweep")
        old = {"name": name, "fingerprint": fingerprint, "made_with": json.loads(made_with)}
        changed = differences(header["made_with"], old["made_with"])
    _check_same(path, [f"{h['name']} ({h['fingerprint']})" for h in (old, header)])
    if changed:
        raise InputError(path, "", "journal", f"was made with {changed}; {ANOTHER}")


def _check_same(path: Path, sweeps: Sequence[str]) -> None:
    was, now = sweeps
    if was != now:
        allowed = f"is of the sweep {was}, not of {now}; {ANOTHER}"
        raise InputError(path, "", "journal", allowed)


def _row(values: dict[str, Any]) -> Row:
    """Return a row of the file as the worker returned it.

    Raises:
        ValueError: it is none; the message names run and field.
    """
    for name, column in COLUMNS.items():
        if column.kind == "bool" and values.get(name) in (0, 1):
            values[name] = bool(values[name])
    try:
        values["sampled"] = json.loads(values.get("sampled", ""))
    except (TypeError, ValueError):
        values["sampled"] = None
    if problem := problem_of(values):
        raise ValueError(problem)
    return values


@contextmanager
def _reading(path: Path) -> Iterator[None]:
    """Raise what is wrong with the content of a journal as an InputError that names it."""
    try:
        yield
    except (sqlite3.Error, ValueError, TypeError, AttributeError) as error:
        why = " ".join(str(error).split())
        raise InputError(path, "", "journal", f"is damaged: {why}; {ANOTHER}") from error
