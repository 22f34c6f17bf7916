"""A page that a process of its own draws."""

import signal
import subprocess
import tempfile
from collections.abc import Sequence
from contextlib import AbstractContextManager
from pathlib import Path

from drake_linefoot.errors import LinefootError


class Drawing(AbstractContextManager["Drawing"]):
    """A page that a process of its own draws; it ends with the `with` block at the latest.

    Attributes:
        page: the file.
    """

    def __init__(self, command: Sequence[str], page: str | Path) -> None:
        """Start the command."""
        self.page = Path(page)
        self._said = tempfile.TemporaryFile("w+")  # where there is room for any number of lines
        nowhere = subprocess.DEVNULL
        self._process = subprocess.Popen(
            command, stdin=nowhere, stdout=nowhere, stderr=self._said, text=True
        )

    def wait(self, shown: Path | None = None) -> None:
        """Wait for the page, which an error calls `shown`, if that is given.

        Raises:
            LinefootError: it was not drawn.
        """
        if status := self._process.wait():
            self._said.seek(0)
            said = self._said.read().strip().splitlines()[-1:] or [_ending(status)]
            raise LinefootError(f"{shown or self.page}: not drawn: {said[0]}")

    def __exit__(self, *_: object) -> None:
        """End the process."""
        self._process.kill()
        self._process.wait()
        self._said.close()


def _ending(status: int) -> str:
    """Return how a process ended that said nothing."""
    if status >= 0:
        return f"its process ended with status {status}"
    return f"its process was ended by {signal.Signals(-status).name}"
