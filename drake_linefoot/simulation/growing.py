"""Arrays on the disk that grow while a run goes on: a folder of npy files.

numpy leaves room in the header of an npy file for a longer first axis, so that it can be written
anew in place. A header counts what is wholly there, so the files can be read at any moment, and
after the process was killed.
"""

import io
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.files import writing
from drake_linefoot.types import Array

SUFFIX = ".npy"


@dataclass(frozen=True)
class StoredArray:
    """An array on the disk, of which memory holds what is used, while it is used.

    Attributes:
        file: npy.
        count: of its rows; the file may have more.
    """

    file: Path
    count: int

    def read(self) -> Array:
        """Map the file; the array cannot be written to."""
        return np.asarray(np.load(self.file, "r"))[: self.count]


class Opened:
    """A recorded run whose arrays are each mapped once: for many looks at them in a row."""

    def __init__(self, owner: Any) -> None:
        self._owner = owner

    def __getattr__(self, name: str) -> Any:
        value = getattr(self._owner, name)
        self.__dict__[name] = value
        return value


class GrowingArrays:
    """One array for each field of a structured dtype, all equally long, in a folder of their own.

    Attributes:
        count: of the rows.
    """

    def __init__(self, folder: Path, dtype: np.dtype[np.void], facts: Mapping[str, Any]) -> None:
        """Make the files, with no row.

        Args:
            folder: is made, and is there only when it has all files.
            dtype: of a row.
            facts: further arrays, which do not grow.

        Raises:
            OutputError: they cannot be made.
        """
        self.count, self._folder, self._dtype = 0, folder.with_name(f"{folder.name}.new"), dtype
        self._names = dtype.names or ()
        with writing(folder):
            self._folder.mkdir()
            for name, value in facts.items():
                np.save(self._path(name), np.asanyarray(value), allow_pickle=False)
            self._write(np.empty(0, dtype))
            self._folder = self._folder.rename(folder)

    def append(self, rows: NDArray[np.void]) -> None:
        """Write rows behind those that are there.

        Raises:
            OutputError: they cannot be written; those before are there.
        """
        with writing(self._folder):
            self._write(rows)

    def cut(self, count: int) -> None:
        """Keep the first `count` rows."""
        self.count = count
        self.append(np.empty(0, self._dtype))

    def arrays(self) -> dict[str, StoredArray]:
        """Return what is there."""
        return {name: StoredArray(self._path(name), self.count) for name in self._names}

    def _path(self, name: str) -> Path:
        return self._folder / f"{name}{SUFFIX}"

    def _write(self, rows: NDArray[np.void]) -> None:
        """Write rows, and the headers, which are equally long whatever they count."""
        count = self.count + len(rows)
        kinds = {name: self._dtype[name] for name in self._names}
        headers = {kind: _header(kind, count) for kind in set(kinds.values())}
        for name, kind in kinds.items():
            header = headers[kind]
            file = os.open(self._path(name), os.O_CREAT | os.O_WRONLY, 0o666)
            try:
                _write(file, rows[name].tobytes(), len(header) + self.count * kind.itemsize)
                _write(file, header, 0)
            finally:
                os.close(file)
        self.count = count


def _header(kind: np.dtype[Any], count: int) -> bytes:
    """Return the header of an npy file of `count` rows of a type."""
    content = io.BytesIO()
    shape = (count, *kind.shape)
    about = {"descr": kind.base.str, "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(content, about)
    return content.getvalue()


def _write(descriptor: int, content: bytes, place: int) -> None:
    """Write all of `content` at a place of a file; a disk that fills up takes a part of it."""
    left = memoryview(content)
    while left:
        written = os.pwrite(descriptor, left, place)
        left, place = left[written:], place + written
