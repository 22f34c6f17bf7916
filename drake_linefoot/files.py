"""Writing files: all of one or nothing, and errors that name it."""

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from drake_linefoot.errors import OutputError


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
