"""A process that plans, and who asks it: problems go through a pipe, plans come back."""

import os
import pickle
import select
import struct
import subprocess
import sys
import time
import weakref
from typing import IO

import numpy as np

from drake_linefoot.errors import LinefootError
from drake_linefoot.mpc.planner import Planner, Setting
from drake_linefoot.parameters import with_numbers
from drake_linefoot.types import Array

_HEAD = struct.Struct("<qq")  # number of a message, and how many bytes follow
_ERROR = -1  # number of one that says what is wrong


class Worker:
    """A process of its own that plans; it is begun anew when it has ended.

    Attributes:
        begun: how often it was begun.
    """

    def __init__(self, setting: Setting) -> None:
        """Begin it; `setting` is what it plans for."""
        self._setting, self.begun = setting, 0
        self._asked: Array | None = None
        self._begin()

    def ask(self, problem: Array) -> None:
        """Let it solve a problem, see `pack`; it does one after the other.

        Raises:
            LinefootError: what it says went wrong.
        """
        self._number += 1
        self._asked, self._since = problem.copy(), time.monotonic()
        try:
            while select.select([self._of], [], [], 0.0)[0]:
                self._receive()  # of a problem that nobody asks for any more
            _send(self._to, self._number, self._asked.tobytes())
        except (BrokenPipeError, EOFError):
            pass  # which `answer` meets

    def answer(self, problem: Array, patience: float) -> Array | None:
        """Return the plan of a problem.

        One that was not the last to be asked, as where a context was copied or set back, is asked
        now and waited for.

        Args:
            problem: see `pack`.
            patience: so long after it was asked it is waited for [s].

        Returns:
            The plan's vector; None if it takes longer, or if the process has ended: then it was
            begun anew, and asked again. Who has endless patience waits for that.

        Raises:
            LinefootError: the problem ends the process, or what it says went wrong.
        """
        if self._asked is None or not np.array_equal(problem, self._asked):
            self.ask(problem)
            patience = np.inf
        for _ in range(2):
            try:
                while True:
                    left = max(self._since + patience - time.monotonic(), 0.0)
                    wait = None if np.isinf(left) else left
                    if not select.select([self._of], [], [], wait)[0]:
                        return None
                    number, plan = self._receive()
                    if number == self._number:
                        self._asked = None
                        return np.frombuffer(plan).copy()
            except EOFError:
                self.close()
                self._begin()
                self.ask(problem)
                if np.isfinite(patience):
                    return None
        raise LinefootError("the process of the MPC ended twice while it solved a problem")

    def _receive(self) -> tuple[int, bytes]:
        number, content = _receive(self._of)
        if number == _ERROR:
            raise LinefootError(f"the process of the MPC: {content.decode()}")
        return number, content

    def close(self) -> None:
        """End the process."""
        self._finalizer()

    def _begin(self) -> None:
        self._number, self._since, self.begun = 0, 0.0, self.begun + 1
        self._asked = None
        process = subprocess.Popen(
            [sys.executable, "-m", "drake_linefoot.mpc.worker"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            bufsize=0,
            start_new_session=True,  # Ctrl-C in a terminal is for who asks
            env=os.environ | {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path)},
        )
        assert process.stdin is not None and process.stdout is not None
        self.pid, self._to, self._of = process.pid, process.stdin, process.stdout
        self._finalizer = weakref.finalize(self, _end, process)
        _send(self._to, 0, pickle.dumps(self._setting))


def pack(numbers: Array, dynamics: Array, reference: Array, previous: Array) -> Array:
    """Return a problem: the numbers of the MPC's parameters, its two signals, the last plan."""
    return np.concatenate([numbers, dynamics, reference, previous])


def _end(process: "subprocess.Popen[bytes]") -> None:
    process.kill()
    for pipe in (process.stdin, process.stdout):
        if pipe is not None:
            pipe.close()
    process.wait()


def _send(pipe: IO[bytes], number: int, content: bytes) -> None:
    left = memoryview(_HEAD.pack(number, len(content)) + content)
    while left:
        left = left[pipe.write(left) :]


def _receive(pipe: IO[bytes]) -> tuple[int, bytes]:
    """Return the next message; raises EOFError where none comes any more."""
    number, length = _HEAD.unpack(_read(pipe, _HEAD.size))
    return number, _read(pipe, length)


def _read(pipe: IO[bytes], length: int) -> bytes:
    parts, left = [], length
    while left:
        part = pipe.read(left)
        if not part:
            raise EOFError
        parts.append(part)
        left -= len(part)
    return b"".join(parts)


def serve(problems: IO[bytes], plans: IO[bytes]) -> None:
    """Solve problems until none comes any more; the first message is the `Setting`."""
    try:
        setting: Setting = pickle.loads(_receive(problems)[1])
        planner = Planner(setting)
        of = planner.layouts
        ends = np.cumsum([of[name].size for name in ("plan", "reference", "dynamics")])
        while True:
            number, content = _receive(problems)
            problem = np.frombuffer(content).copy()
            numbers, d, reference, previous = np.split(problem, len(problem) - ends[::-1])
            constants = planner.constants(with_numbers(setting.parameters, numbers))
            plan = planner.plan(
                of["dynamics"].open(d),
                of["reference"].open(reference),
                of["plan"].open(previous),
                constants,
            )
            _send(plans, number, of["plan"].vector(plan).tobytes())
    except (EOFError, BrokenPipeError):
        return
    except Exception as error:  # whatever it is, who asked is to know
        _send(plans, _ERROR, f"{type(error).__name__}: {error}".encode())


def main() -> None:
    """Be the process: what is printed goes to stderr, the pipe is for plans alone."""
    plans = os.fdopen(os.dup(1), "wb", buffering=0)
    os.dup2(2, 1)
    serve(os.fdopen(0, "rb", buffering=0), plans)


if __name__ == "__main__":
    main()
