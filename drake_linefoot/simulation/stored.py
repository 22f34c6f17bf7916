"""Arrays of an npz file from anywhere: damage and bombs end as one error, not as a traceback."""

import math
import tempfile
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np

from drake_linefoot.checks import shown
from drake_linefoot.errors import InputError
from drake_linefoot.simulation.channels import Channel
from drake_linefoot.simulation.growing import SUFFIX
from drake_linefoot.types import Array

LARGEST_RATIO = 64  # of an archive's content to its file, when it is larger than
LONGEST_GAP = 1.0  # [s] between two samples
SMALL = 2**28  # bytes; that of a recording is 2
COMPRESSIONS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)  # which unpack no more than is wanted

WHAT = "recorded run"  # what errors call it


def read_npz(
    file: Path, names: Sequence[str], largest: int, stack: ExitStack
) -> tuple[dict[str, Array], Path | None]:
    """Return arrays of an npz file by their names, as far as it has them.

    Args:
        file: the file.
        names: of the arrays; others are left out.
        largest: bytes of arrays that are read into memory; more are unpacked and mapped.
        stack: removes the folder of arrays that were unpacked.

    Returns:
        The arrays, and that folder; None without one.

    Raises:
        InputError: it cannot be read, is damaged, or unpacks to far more than its size.
    """
    with _understood(file):
        if file.exists() and not file.is_file():
            raise ValueError("is no file")
        with zipfile.ZipFile(file) as archive:
            have = {info.filename: info for info in archive.infolist()}
            files = {name: f"{name}{SUFFIX}" for name in names}
            wanted = {name: have[entry] for name, entry in files.items() if entry in have}
            unpacked = sum(info.file_size for info in wanted.values())
            if unpacked > max(SMALL, LARGEST_RATIO * file.stat().st_size):
                raise ValueError(f"would unpack to {unpacked / 1e9:.1f} GB")
            for name, info in wanted.items():
                if info.compress_type not in COMPRESSIONS:
                    raise ValueError(f"{name} is compressed otherwise")
            if unpacked <= largest:
                return {name: _array(archive, info) for name, info in wanted.items()}, None
            scratch = tempfile.TemporaryDirectory(prefix="linefoot-", ignore_cleanup_errors=True)
            folder = Path(stack.enter_context(scratch))
            for info in wanted.values():
                archive.extract(info, folder)
    return read_folder(folder, names), folder


def read_folder(folder: Path, names: Sequence[str]) -> dict[str, Array]:
    """Return arrays of a folder of npy files, mapped; otherwise as `read_npz`."""
    with _understood(folder):
        files = {name: folder / f"{name}{SUFFIX}" for name in names}
        return {n: np.asarray(np.load(f, "r")) for n, f in files.items() if f.is_file()}


@contextmanager
def _understood(file: Path) -> Iterator[None]:
    """Raise whatever is raised inside the `with` block as an InputError."""
    try:
        yield
    except Exception as error:  # zipfile, zlib and numpy raise all kinds for damaged files
        reason = getattr(error, "strerror", None) or str(error) or type(error).__name__
        reason = str(shown(" ".join(reason.split())))
        raise InputError(file, "", WHAT, f"cannot be read: {reason}") from error


def _array(archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> Array:
    """Return one array, once its header has been found to fit its size."""
    name = info.filename.removesuffix(SUFFIX)
    with archive.open(info) as stream:
        version = np.lib.format.read_magic(stream)
        read_header = {
            (1, 0): np.lib.format.read_array_header_1_0,
            (2, 0): np.lib.format.read_array_header_2_0,
        }[version]
        shape, _, dtype = read_header(stream)
        size = math.prod(shape) * dtype.itemsize
        if dtype.hasobject or size + stream.tell() != info.file_size:
            raise ValueError(f"{name} has another size than its header says")
    with archive.open(info) as stream:
        array: Array = np.lib.format.read_array(stream, allow_pickle=False)
        if stream.read(1):  # which checks the sum at the end as well
            raise ValueError(f"{name} is longer than its header says")
    return array


def check_run(stored: Mapping[str, Array], file: Path, channels: Mapping[str, Channel]) -> None:
    """Check that arrays of a file are of the kinds and shapes of a run, and its times in order.

    Raises:
        InputError: one is not.
    """
    for names, kind, what in (
        (("scenario", "version", "joint_names", "fall_reason"), "U", "text"),
        (("fell",), "b", "true or false"),
        (("fall_time", "wall_seconds", "effort_limits", *channels), "f", "numbers"),
    ):
        for name in names:
            if stored[name].dtype.kind != kind:
                raise InputError(file, name, str(stored[name].dtype), f"must be {what}")
    widths = {f"n{s}": stored[s].shape[1] if stored[s].ndim == 2 else 0 for s in ("q", "v")}
    sizes = {**widths, "na": stored["joint_names"].size}
    n = stored["time"].size
    shapes = {name: (n, *channel.shape(sizes)) for name, channel in channels.items()}
    shapes |= {"joint_names": (sizes["na"],), "effort_limits": (sizes["na"],)}
    for name, array in stored.items():
        shape = shapes.get(name, ())
        if array.shape != shape or 0 in shape[1:]:
            raise InputError(file, name, f"of shape {array.shape}", f"must have {shape}")
    steps = np.diff(stored["time"], prepend=0.0)
    if not ((steps[1:] > 0.0).all() and (steps >= 0.0).all() and (steps <= LONGEST_GAP).all()):
        raise InputError(file, "time", f"of {n} samples", "must begin at 0 and go on in steps")
