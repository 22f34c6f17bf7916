"""Files: read when they are files of a sensible size, written whole or not at all."""

import errno
import os
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from drake_linefoot.errors import OutputError


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


def write_file(path: str | Path, content: bytes) -> None:
    """Write one file, with the folders it needs: all of it, or on an error nothing.

    Raises:
        OutputError: it cannot be written.
    """
    target = Path(path)
    with writing(path):
        target.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".linefoot-", dir=target.parent) as scratch:
            new = Path(scratch) / "new"
            new.write_bytes(content)
            os.replace(new, target)
