"""Which function is compiled by which of two processes that share a folder: none by both.

Whoever compiles a function holds a lock on a byte of a file that stands for it, until its machine
code is kept. Functions do not call each other in circles, so no two processes wait for each other;
the system frees the locks of a process that ends.
"""

import fcntl
import hashlib
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

FILE = "claims"  # in the folder of the machine code, while it is shared


class TakenError(Exception):
    """Another process compiles what this one was about to begin with."""


class Claims:
    """What this process is compiling."""

    def __init__(self, file: BinaryIO, waits: bool) -> None:
        """Claim nothing yet.

        Args:
            file: whose bytes are locked; open for writing.
            waits: whether to wait for what another process compiles, even with nothing begun.
        """
        self._file, self._waits, self._held = file, waits, set[int]()

    def take(self, name: str) -> bool:
        """Claim a function; wait while another process compiles it.

        Returns:
            Whether it has waited, and the function may be there now.

        Raises:
            TakenError: another process compiles it, and this one neither waits nor has begun any.
        """
        place = _place(name)
        if place in self._held:
            return False
        waited = not self._lock(place, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if waited:
            if not (self._waits or self._held):
                raise TakenError(name)
            self._lock(place, fcntl.LOCK_EX)
        self._held.add(place)
        return waited

    def free(self, name: str) -> None:
        """Let other processes have a function, which is kept now."""
        place = _place(name)
        if place in self._held:
            self._lock(place, fcntl.LOCK_UN)
            self._held.remove(place)

    def free_all(self) -> None:
        """Let other processes have what could not be compiled."""
        for place in self._held:
            self._lock(place, fcntl.LOCK_UN)
        self._held.clear()

    def _lock(self, place: int, how: int) -> bool:
        """Return whether a byte could be locked; where there are no locks each one is free."""
        try:
            fcntl.lockf(self._file, how, 1, place)
        except BlockingIOError:
            return False
        except OSError:  # of a file system without locks, or waiting would never end
            return True
        return True


class _Shared:
    """The claims of this process, while it shares the work."""

    claims: Claims | None = None


def claims() -> Claims | None:
    """Return the claims of this process; None while it works alone."""
    return _Shared.claims


@contextmanager
def shared(folder: Path | None, waits: bool) -> Iterator[None]:
    """Share the work with another process in the `with` block.

    Args:
        folder: of the machine code; None to work alone.
        waits: see `Claims`.
    """
    with ExitStack() as closing:
        with suppress(OSError):
            if folder is not None:
                file = closing.enter_context((folder / FILE).open("wb"))
                _Shared.claims = Claims(file, waits)
        try:
            yield
        finally:
            _Shared.claims = None
            if folder is not None and waits:
                (folder / FILE).unlink(missing_ok=True)


def _place(name: str) -> int:
    return int.from_bytes(hashlib.sha256(name.encode()).digest()[:6])
