"""Jobs for worker processes, which can load them by name."""

import ctypes
import os
import signal
import sys
import time


def double(x):
    """Return twice as much."""
    return 2 * x


def pid_of(x):
    """Return which process does it."""
    return os.getpid()


def refuse(x):
    """Raise an error of a job."""
    raise ValueError(f"{x} is refused")


def sleep(x):
    """Wait, as long as nobody ends this process."""
    time.sleep(600.0)


def trouble(x):
    """Die at 2 by a signal, at 3 by an exit, and hang at 4 as compiled code does."""
    if x == 2:
        os.kill(os.getpid(), signal.SIGKILL)
    if x == 3:
        os._exit(7)
    if x == 4:
        ctypes.PyDLL(None).sleep(1000)  # no other thread of Python goes on
    return x


def too_much(x):
    """Ask for more memory than there is, as far as Python knows."""
    if x == 1:
        return len(bytearray(sys.maxsize))
    return x


def die_once(file):
    """Die the first time, which a file remembers."""
    if not file.exists():
        file.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return "done"
