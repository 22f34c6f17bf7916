"""Files: read when they are files of a sensible size, written whole or not at all."""

import errno
import fcntl
import os
import re
import shutil
import stat
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

from drake_linefoot.errors import OutputError

SCRATCH = {"new", "old"}  # what is in a scratch folder: what is being written, what was there


def read_file(path: str | Path, largest: int) -> bytes:
    """Return the content of a file, which must be no device, and not too large.

    Args:
        path: of the file.
        largest: number of bytes that it may have.

    Raises:
        OSError: it cannot be read, or is no such file.
        ValueError: the path is none.
    """
    kind = os.stat(path).st_mode
    if not stat.S_ISREG(kind) and not stat.S_ISDIR(kind):  # a FIFO waits, /dev/zero never ends
        raise OSError(errno.EINVAL, "is no regular file")
    with open(path, "rb") as file:
        content = file.read(largest + 1)
    if len(content) > largest:
        raise OSError(errno.EFBIG, f"is larger than {largest >> 10} KiB")
    return content


@contextmanager
def writing(path: str | Path) -> Iterator[None]:
    """Raise an OSError inside the `with` block as an OutputError that names `path`."""
    try:
        yield
    except OutputError:
        raise
    except OSError as error:
        raise OutputError(path, error.strerror or str(error)) from error


@contextmanager
def scratch_folder(parent: Path, prefix: str, adopt: Callable[[Path], None]) -> Iterator[Path]:
    """Make a folder that is removed at the end; gives its path.

    Those that killed processes have left are removed as well. A folder is known to be in use by
    its lock, which ends with the process.

    Args:
        parent: where it is made.
        prefix: of its name.
        adopt: called with each folder that was left, before that is removed.
    """
    left = re.compile(re.escape(prefix) + r"[a-z0-9_]{8}")  # as tempfile names them
    for folder in [path for path in parent.iterdir() if left.fullmatch(path.name)]:
        with suppress(OSError), _locked(folder, fcntl.LOCK_NB):
            found = {path.name for path in folder.iterdir()}
            if found and found <= SCRATCH:  # an empty one may have been made just now
                adopt(folder)
                shutil.rmtree(folder)
    with (
        tempfile.TemporaryDirectory(prefix=prefix, dir=parent) as scratch,
        _locked(Path(scratch), 0),
    ):
        yield Path(scratch)


@contextmanager
def _locked(folder: Path, how: int) -> Iterator[None]:
    """Hold the lock of a folder; with LOCK_NB an OSError when another process does."""
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | how)
        yield
    finally:
        os.close(descriptor)


def write_file(path: str | Path, content: bytes) -> None:
    """Write one file, with the folders it needs: all of it, or on an error nothing.

    Raises:
        OutputError: it cannot be written.
    """
    with new_file(path) as file:
        file.write(content)


@contextmanager
def new_file(path: str | Path) -> Iterator[IO[bytes]]:
    """Give a file to write, which is at `path` at the end of the `with` block, as `write_file`."""
    target = Path(path)
    with writing(path):
        target.parent.mkdir(parents=True, exist_ok=True)
        with scratch_folder(target.parent, ".linefoot-", lambda folder: None) as scratch:
            new = scratch / "new"
            with new.open("wb") as file:
                yield file
            os.replace(new, target)
