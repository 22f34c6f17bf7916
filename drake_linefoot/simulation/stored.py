"""Arrays of an npz file from anywhere: damage and bombs end as one error, not as a traceback."""

import zipfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from drake_linefoot.checks import shown
from drake_linefoot.errors import InputError
from drake_linefoot.types import Array

LARGEST_RATIO = 64  # of an archive's content to its file, when it is larger than
SMALL = 2**28  # bytes; that of a recording is 2
COMPRESSIONS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)  # which unpack no more than is wanted
SUFFIX = ".npy"


def read_arrays(file: Path, names: Sequence[str], what: str) -> dict[str, Array]:
    """Return arrays of an npz file by their names, as far as it has them.

    Args:
        file: the file.
        names: of the arrays; others are left out.
        what: it should hold, for the message of an error.

    Raises:
        InputError: it cannot be read, is damaged, or unpacks to far more than its size.
    """
    try:
        if file.exists() and not file.is_file():
            raise ValueError("is no file")
        with zipfile.ZipFile(file) as archive:
            found = {name: f"{name}{SUFFIX}" for name in names}
            have = {info.filename: info for info in archive.infolist()}
            wanted = {name: have[entry] for name, entry in found.items() if entry in have}
            unpacked = sum(info.file_size for info in wanted.values())
            if unpacked > max(SMALL, LARGEST_RATIO * file.stat().st_size):
                raise ValueError(f"would unpack to {unpacked / 1e9:.1f} GB")
            return {name: _array(archive, info) for name, info in wanted.items()}
    except Exception as error:  # zipfile, zlib and numpy raise all kinds for damaged files
        reason = getattr(error, "strerror", None) or str(error) or type(error).__name__
        reason = str(shown(" ".join(reason.split())))
        raise InputError(file, "", what, f"cannot be read: {reason}") from error


def _array(archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> Array:
    """Return one array, once its header has been found to fit its size."""
    name = info.filename.removesuffix(SUFFIX)
    if info.compress_type not in COMPRESSIONS:
        raise ValueError(f"{name} is compressed otherwise")
    with archive.open(info) as stream:
        version = np.lib.format.read_magic(stream)
        read_header = {
            (1, 0): np.lib.format.read_array_header_1_0,
            (2, 0): np.lib.format.read_array_header_2_0,
        }[version]
        shape, _, dtype = read_header(stream)
        items = 1
        for length in shape:  # numbers of Python do not overflow
            items *= length
        if dtype.hasobject or items * dtype.itemsize + stream.tell() != info.file_size:
            raise ValueError(f"{name} has another size than its header says")
    with archive.open(info) as stream:
        array: Array = np.lib.format.read_array(stream, allow_pickle=False)
        if stream.read(1):  # which checks the sum at the end as well
            raise ValueError(f"{name} is longer than its header says")
    return array
