"""A process that answers lines of JSON."""

import json
import os
import subprocess
import sys
from collections.abc import Sequence
from contextlib import ExitStack
from typing import Any

from drake_linefoot.errors import LinefootError


class LineWorker(ExitStack):
    """The process; it ends with this context manager."""

    def __init__(self, name: str, command: Sequence[str]) -> None:
        """Start it; `name` is what an error calls it.

        Raises:
            LinefootError: it does not start.
        """
        super().__init__()
        self._name, pipe = name, subprocess.PIPE
        own = _environment(command[0])
        try:
            process = subprocess.Popen(
                command, stdin=pipe, stdout=pipe, stderr=pipe, text=True, env=own
            )
        except OSError as error:
            raise LinefootError(f"{command[0]}: {error.strerror}") from error
        self._process = self.enter_context(process)

    def ask(self, question: dict[str, Any]) -> dict[str, Any]:
        """Send a line and return the answer.

        Raises:
            LinefootError: there is none; it has the last words of the process.
        """
        self.send(question)
        return self.receive()

    def send(self, question: dict[str, Any]) -> None:
        """Send a line; whoever does has to `receive` its answer."""
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(json.dumps(question) + "\n")
            self._process.stdin.flush()
        except OSError:
            pass  # there will be no answer

    def receive(self) -> dict[str, Any]:
        """Return the answer to what was sent, see `ask`."""
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            _, said = self._process.communicate()
            last = (said.strip().splitlines() or ["no answer"])[-1]
            self.close()
            raise LinefootError(f"{self._name}: {last}")
        answer: dict[str, Any] = json.loads(line)
        return answer


def _environment(python: str) -> dict[str, str]:
    """Return the environment of an interpreter; another than this one has its own packages."""
    paths = () if python == sys.executable else ("PYTHONPATH",)
    return {name: value for name, value in os.environ.items() if name not in paths}
