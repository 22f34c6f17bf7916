"""The journal of a sweep: one line of JSON a run, on the disk before the next one counts.

It is what a sweep that was killed goes on from. A line that was half-written is no run.
"""

import fcntl
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

from drake_linefoot.errors import InputError, OutputError
from drake_linefoot.files import writing
from drake_linefoot.lab.sweep.jobs import Key
from drake_linefoot.lab.sweep.provenance import differences
from drake_linefoot.lab.sweep.rows import Row, key_of

JOURNAL = "journal.jsonl"


@dataclass
class Journal:
    """An open journal.

    Attributes:
        path: of the file.
        file: itself.
        rows: by run; one each, however often it was done.
    """

    path: Path
    file: IO[bytes]
    rows: dict[Key, Row]

    def add(self, row: Row) -> bool:
        """Write a row so that it survives the process; return False when its run has one.

        Raises:
            OutputError: it cannot be written.
        """
        key = key_of(row)
        if key in self.rows:
            return False
        with writing(self.path):
            try:
                _write(self.file, _line(row))
                self.rows[key] = row  # before the disk has it: Ctrl-C meanwhile must not lose count
                os.fsync(self.file.fileno())
            except OSError:
                self.rows.pop(key, None)
                raise
        return True


@contextmanager
def open_journal(
    folder: Path, header: dict[str, Any], fresh: bool, retry: bool = False
) -> Iterator[Journal]:
    """Open the journal of a folder, and keep other processes from writing to it.

    Args:
        folder: exists.
        header: `name`, `fingerprint` and `made_with`, which an older journal must have as well.
        fresh: begin anew.
        retry: count the runs without an outcome as not done; the file keeps them until they are.

    Raises:
        InputError: it is the journal of something else, or another process writes to it.
        OutputError: it cannot be written.
    """
    path = folder / JOURNAL
    with writing(path):
        file = path.open("ab+", buffering=0)
    with file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            raise OutputError(path, "another sweep is writing to it") from error
        if fresh:
            file.truncate(0)
        rows = _begin(path, file, header)
        if retry:
            rows = {key: row for key, row in rows.items() if not row["error"]}
        yield Journal(path, file, rows)


def _begin(path: Path, file: IO[bytes], header: dict[str, Any]) -> dict[Key, Row]:
    """Return the rows that are there, with the file ready for the next one."""
    file.seek(0)
    content = file.read()
    whole = content[: content.rfind(b"\n") + 1]
    if len(whole) < len(content):
        file.truncate(len(whole))
    if not whole:
        _write(file, _line(header))
        os.fsync(file.fileno())
        return {}
    try:
        first, *rows = [json.loads(line) for line in whole.splitlines()]
        by_key: dict[Key, Row] = {}
        for row in rows:
            if by_key.get(key_of(row), {"error": "not done"})["error"]:
                by_key[key_of(row)] = row
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(path, "", "journal", f"is damaged: {error}; see --fresh") from error
    _check_header(path, first, header)
    return by_key


def _check_header(path: Path, old: dict[str, Any], new: dict[str, Any]) -> None:
    for entry in ("name", "fingerprint"):
        if old.get(entry) != new[entry]:
            was, now = (f"{h.get('name')} ({h.get('fingerprint')})" for h in (old, new))
            allowed = f"is of the sweep {was}, not of {now}; name another --out, or --fresh"
            raise InputError(path, "", "journal", allowed)
    changed = differences(new["made_with"], old.get("made_with", {}))
    if changed:
        allowed = f"was made with {changed}; name another --out, or --fresh"
        raise InputError(path, "", "journal", allowed)


def _write(file: IO[bytes], line: bytes) -> None:
    """Append a line: all of it, or on an error nothing, however full the disk is."""
    end, left = os.fstat(file.fileno()).st_size, memoryview(line)
    try:
        while left:
            left = left[file.write(left) :]  # a disk that fills up takes a part of it
    except OSError:
        with suppress(OSError):
            os.ftruncate(file.fileno(), end)
        raise


def _line(content: dict[str, Any]) -> bytes:
    return json.dumps(content, allow_nan=False).encode() + b"\n"
