"""How long a tick of the controller takes while the robot walks, and on what machine."""

import os
import platform
import time
from collections.abc import Sequence
from typing import Any

import numpy as np

from drake_linefoot.lab.remote.control import RemoteControl
from drake_linefoot.lab.remote.messages import RobotInput, RobotOutput, WalkCommand

SHARES = {"half of the ticks": 50.0, "99 %": 99.0, "99.9 %": 99.9, "all": 100.0}
_POLICIES = {
    getattr(os, name): name
    for name in ("SCHED_OTHER", "SCHED_BATCH", "SCHED_IDLE", "SCHED_FIFO", "SCHED_RR")
    if hasattr(os, name)
}


class LocalLine:
    """Carries messages to a control in this process, and takes the time of its answers.

    Attributes:
        control: it answers.
        times: of each answer [s].
    """

    def __init__(self, control: RemoteControl) -> None:
        """Carry messages to `control`."""
        self.control, self.times, self._newest = control, list[float](), list[RobotInput]()

    def publish(self, message: tuple[Any, ...]) -> None:
        """Have a message answered."""
        if isinstance(message, WalkCommand):
            self.control.command(message)
        elif isinstance(message, RobotOutput):
            start = time.perf_counter()
            answer = self.control.answer(message)
            self.times.append(time.perf_counter() - start)
            if answer is not None:
                self._newest = [answer]

    def wait(self, timeout: float) -> None:
        """Return at once: what there is has come."""

    def take(self, kind: type[RobotInput]) -> RobotInput | None:
        """Return the newest answer."""
        return self._newest.pop() if self._newest else None


def table_of(times: Sequence[float], period: float) -> list[tuple[str, str]]:
    """Return what is said of the times of ticks [s] with a period [s]: what, and how much.

    The first tick, in which it begins, is not counted.
    """
    milliseconds = 1e3 * np.array(times[1:])
    rows = [
        (f"{share} took at most", f"{np.percentile(milliseconds, percent):.2f} ms")
        for share, percent in SHARES.items()
    ]
    late = float((milliseconds > 1e3 * period).mean())
    return [*rows, (f"longer than the period of {1e3 * period:g} ms", f"{100.0 * late:.2f} %")]


def machine() -> list[tuple[str, str]]:
    """Return what the times depend on: cores, who else uses them, how this process is scheduled."""
    rows = [("machine", f"{platform.machine()}, {os.cpu_count()} cores")]
    if hasattr(os, "getloadavg"):
        rows.append(("processes that want a core", f"{os.getloadavg()[0]:.1f}"))
    if hasattr(os, "sched_getscheduler"):
        policy = _POLICIES.get(os.sched_getscheduler(0), "unknown")
        cores = len(os.sched_getaffinity(0))
        rows.append(("scheduled", f"{policy}, on {cores} of the cores"))
    return rows
