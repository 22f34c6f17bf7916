"""Ctrl-C, SIGTERM and SIGHUP while something runs whose results must not be lost."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


@dataclass
class Interruption:
    """What came so far."""

    number: int = 0  # of the signal; 0 before one came

    @property
    def status(self) -> int:
        """Exit status of a program that ended by it: 130, 143, 129; 0 before one came."""
        return 128 + self.number if self else 0

    def __bool__(self) -> bool:
        return self.number != 0


@contextmanager
def interruptions() -> Iterator[Interruption]:
    """Keep the first Ctrl-C, SIGTERM or SIGHUP inside the `with` block; a second one acts as ever.

    Nothing is raised, in compiled code least of all, so the block has to look. A signal that is
    ignored stays so. Outside of the main thread, where signals never come, it stays empty.
    """
    interruption = Interruption()
    if threading.current_thread() is not threading.main_thread():
        yield interruption
        return
    handlers = {number: signal.getsignal(number) for number in SIGNALS}
    before = {n: h for n, h in handlers.items() if h not in {None, signal.SIG_IGN}}

    def restore() -> None:
        for number, handler in before.items():
            signal.signal(number, handler)

    def interrupt(number: int, frame: FrameType | None) -> None:
        interruption.number = number
        restore()

    for number in before:
        signal.signal(number, interrupt)
    try:
        yield interruption
    finally:
        restore()
