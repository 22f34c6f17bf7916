"""A run on the disk: one file that is appended to, readable at any moment and after a kill.

It is an Arrow IPC stream, which pyarrow and pandas open without us: a column for each channel, a
row for each sample, half a second of them in a batch; shapes, units and the scenario in the
metadata of the schema, checksums in that of each batch. A batch may say how many of the rows before
it still count, for a run that went back in time; the last one says how the run ended. Without it
the run was killed, or goes on.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from math import prod
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from drake_linefoot.errors import InputError, legible
from drake_linefoot.files import writing
from drake_linefoot.layout import Part
from drake_linefoot.types import Array

WHAT = "recorded run"  # what errors call it
FORMAT = "drake_linefoot.log.2"
MOST = 1e15  # size of a number, as which a larger one is written; NaN stays
LARGEST = 2**30  # bytes of a log that is kept in memory as it is used
_SAID, _SUM, _UNIT = b"drake_linefoot", b"crc32", b"unit"  # keys of metadata


class LogFile:
    """A log that is written.

    Attributes:
        path: of the file.
        count: rows that count.
        dtype: of a row.
    """

    def __init__(
        self,
        path: Path,
        dtype: np.dtype[np.void],
        channels: Mapping[str, Part],
        facts: Mapping[str, Any],
    ) -> None:
        """Make the file, with no row.

        Args:
            path: is made.
            dtype: of a row.
            channels: what each field of it is.
            facts: what can be said of the run at its beginning, as JSON takes it.

        Raises:
            OutputError: it cannot be made.
        """
        self.path, self.count = path, 0
        self._keep: int | None = None  # rows before the next ones that still count
        self.dtype, self._shapes = dtype, {name: dtype[name].shape for name in dtype.names or ()}
        columns = [
            pa.field(name, _type(shape), False, {_UNIT: channels[name].unit})
            for name, shape in self._shapes.items()
        ]
        said = {"format": FORMAT, "shapes": self._shapes, "facts": dict(facts)}
        self._schema = pa.schema(columns, _signed(said))
        with writing(path):
            new = path.with_name(f"{path.name}.new")
            self._file = pa.OSFile(str(new), "wb")
            self._stream = pa.ipc.new_stream(self._file, self._schema)
        self._write(np.empty(0, dtype))  # with which the schema is there
        with writing(path):
            new.rename(path)  # who has mapped what was there keeps it

    def append(self, rows: NDArray[np.void]) -> None:
        """Write rows behind those that count.

        Raises:
            OutputError: they cannot be written; those before are there.
        """
        self._write(rows)
        self.count, self._keep = self.count + len(rows), None

    def cut(self, count: int) -> None:
        """Let the first `count` rows count, and no other."""
        self.count = self._keep = count

    def end(self, facts: Mapping[str, Any]) -> None:
        """Say how the run ended, as JSON takes it; close the file."""
        self._write(np.empty(0, self.dtype), dict(facts))
        with writing(self.path):
            self._stream.close()
            self._file.close()

    def _write(self, rows: NDArray[np.void], ended: dict[str, Any] | None = None) -> None:
        values = {name: np.clip(rows[name], -MOST, MOST) for name in self._shapes}
        columns = [_column(values[name], shape) for name, shape in self._shapes.items()]
        batch = pa.RecordBatch.from_arrays(columns, schema=self._schema)
        sums = [crc32(v) for v in values.values()]
        said = _signed({"keep": self._keep, "sums": sums, "ended": ended})
        with writing(self.path):
            self._stream.write_batch(batch, custom_metadata=said)


def _signed(said: Mapping[str, Any]) -> dict[bytes, bytes]:
    """Return what is said as metadata, with its checksum."""
    text = json.dumps(said).encode()
    return {_SAID: text, _SUM: str(crc32(text)).encode()}


def _opened(metadata: Any) -> dict[str, Any]:
    """Return what metadata says.

    Raises:
        ValueError: it is damaged, or says nothing.
    """
    found = dict(metadata or {})
    if _SAID not in found or str(crc32(found[_SAID])).encode() != found.get(_SUM):
        raise ValueError("is no log, or is damaged")
    said: dict[str, Any] = json.loads(found[_SAID])
    return said


def _type(shape: tuple[int, ...]) -> pa.DataType:
    return pa.list_(pa.float64(), prod(shape)) if shape else pa.float64()


def _column(values: Array, shape: tuple[int, ...]) -> pa.Array:
    flat = pa.array(values.ravel())
    return pa.FixedSizeListArray.from_arrays(flat, prod(shape)) if shape else flat


@dataclass(frozen=True)
class _Batch:
    """Rows that were written together, mapped into memory."""

    values: Mapping[str, Array]  # of each channel
    sums: Mapping[str, int]  # checksums of all of them
    count: int  # how many of them count


@dataclass(frozen=True)
class Log:
    """A log that was read, mapped into memory: what is used is there, while it is used.

    Attributes:
        file: it was read from.
        facts: what was said at its beginning.
        ended: what was said at its end; None without.
        shapes: of a row of each channel, by its name.
    """

    file: Path
    facts: dict[str, Any]
    ended: dict[str, Any] | None
    shapes: dict[str, tuple[int, ...]]
    _batches: list[_Batch] = field(repr=False)
    _whole: dict[str, Array] = field(repr=False, default_factory=dict)  # kept of a short log

    @property
    def count(self) -> int:
        """Number of rows."""
        return sum(batch.count for batch in self._batches)

    def channel(self, name: str) -> Array:
        """Return all rows of a channel; of several batches a copy, which a short log keeps.

        Raises:
            InputError: they are not what was written.
        """
        if name in self._whole:
            return self._whole[name]
        rows = []
        for batch in self._batches:
            values = batch.values[name]
            if crc32(values) != batch.sums[name]:  # type: ignore[arg-type]
                raise InputError(self.file, name, WHAT, "is damaged")
            rows.append(values[: batch.count])
        if not rows:
            return np.empty((0, *self.shapes[name]))
        whole = rows[0] if len(rows) == 1 else np.concatenate(rows)
        if self.file.stat().st_size < LARGEST:
            self._whole[name] = whole
        return whole

    def readers(self, names: Iterable[str]) -> dict[str, Reader]:
        """Return what reads each of some channels when it is used."""
        return {name: Reader(self, name) for name in names}


class Reader:
    """A channel of a log, read when it is used."""

    def __init__(self, log: Log, name: str) -> None:
        """Keep log and name."""
        self.log, self.name = log, name

    @property
    def shape(self) -> tuple[int, ...]:
        """Of what `read` returns."""
        return self.log.count, *self.log.shapes[self.name]

    def read(self) -> Array:
        """Return its rows."""
        return self.log.channel(self.name)


def read_log(file: Path) -> Log:
    """Read a log, as far as it is whole.

    Raises:
        InputError: it cannot be read, or is no log.
    """
    if file.is_file() and not file.stat().st_size:
        raise InputError(file, "", WHAT, "is empty: the run ended before anything was recorded")
    try:
        stream = pa.ipc.open_stream(pa.memory_map(str(file)))
        said = _opened(stream.schema.metadata)
        if said["format"] != FORMAT:
            raise ValueError("of another format")
        shapes = {name: tuple(shape) for name, shape in said["shapes"].items()}
        facts = dict(said["facts"])
        for name, shape, found in zip(shapes, shapes.values(), stream.schema, strict=True):
            if (found.name, found.type) != (name, wanted := _type(shape)):
                raise ValueError(f"{found.name}: {found.type} instead of {name}: {wanted}")
    except Exception as error:  # pyarrow and json raise all kinds for damaged files
        reason = legible(str(error)) or type(error).__name__
        raise InputError(file, "", WHAT, f"cannot be read: {reason}") from error
    batches: list[_Batch] = []
    ended = None
    while ended is None:
        try:
            batch, metadata = stream.read_next_batch_with_custom_metadata()
            batch.validate(full=True)
            says = _opened(metadata)
            values = {name: _values(batch.column(name), shape) for name, shape in shapes.items()}
            sums = dict(zip(shapes, says["sums"], strict=True))
            kept = batches if says["keep"] is None else list(_first(batches, says["keep"]))
            ended = None if says["ended"] is None else dict(says["ended"])
        except Exception:  # the end, or where it stops to be whole
            break
        batches = kept
        if len(batch):
            batches.append(_Batch(values, sums, len(batch)))
    return Log(file, facts, ended, shapes, batches)


def _values(column: pa.Array, shape: tuple[int, ...]) -> Array:
    flat = column.flatten() if shape else column
    values: Array = flat.to_numpy(zero_copy_only=True)
    return values.reshape(len(column), *shape)


def _first(batches: list[_Batch], count: int) -> Iterator[_Batch]:
    """Yield the batches of the first `count` rows."""
    for batch in batches:
        if count <= 0:
            return
        yield replace(batch, count=min(batch.count, count))
        count -= batch.count
