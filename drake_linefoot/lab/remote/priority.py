"""Real-time scheduling of the process that a controller is in."""

import os

from drake_linefoot.errors import InputError

HELPERS, TICKS = 10, 20  # of `SCHED_FIFO`: what a controller starts, and itself


def run_first(priority: int) -> None:
    """Run this thread, and what it starts from now on, before all that is not of real time.

    Args:
        priority: of two such processes the one with the larger runs, see `HELPERS`.

    Raises:
        InputError: this system has no such scheduling, or does not allow it to this user.
    """
    allowed = "must be left out: this system has no SCHED_FIFO"
    if hasattr(os, "SCHED_FIFO"):
        try:
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
        except PermissionError:
            allowed = "must be left out, or allowed: by root, or a limit `rtprio` of this user"
        else:
            return
    raise InputError("linefoot", "--first", priority, allowed)
