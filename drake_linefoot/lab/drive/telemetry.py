"""How a drive goes: its pace, numbers for its pages, and lines for the terminal."""

from collections import deque
from collections.abc import Iterable
from typing import Any

import numpy as np

from drake_linefoot.lab.drive.session import Session
from drake_linefoot.lab.drive.teleop import Orders
from drake_linefoot.lab.simulation.velocity import recent_velocity
from drake_linefoot.lab.simulation.warnings import warnings_of
from drake_linefoot.lab.visualization.replay import SOURCES, on_ground, rounded
from drake_linefoot.mpc.models.registry import MODELS

WINDOW = 1.0  # [s] of wall time over which the rate is measured
BACKLOG = 0.1  # [s] it may be late and still catch up; what is more is given up
TOO_SLOW = 0.95  # [-] of real time; below it the machine does not keep up


class Pace:
    """Holds simulated time back to that of a clock, and says when it cannot keep up.

    Attributes:
        rate: simulated seconds per second over the last second; 1 before anything is known.
    """

    def __init__(self) -> None:
        self.rate = 1.0
        self.restart()

    def restart(self) -> None:
        """Count from now on: after a pause, a reset or a fall."""
        self._anchor: float | None = None
        self._seen: deque[tuple[float, float]] = deque()

    @property
    def keeps_up(self) -> bool:
        """Whether the simulation is as fast as real time."""
        return self.rate >= TOO_SLOW

    def wait(self, time: float, clock: float) -> float:
        """Return how long to wait so that simulated time does not run ahead of the clock [s]."""
        if self._anchor is None:
            self._anchor = clock - time
        ahead = time - (clock - self._anchor)
        if ahead < -BACKLOG:
            self._anchor += -BACKLOG - ahead
        self._measure(time, clock)
        return max(ahead, 0.0)

    def _measure(self, time: float, clock: float) -> None:
        self._seen.append((time, clock))
        while len(self._seen) > 2 and clock - self._seen[1][1] >= WINDOW:
            self._seen.popleft()
        first_time, first_clock = self._seen[0]
        if clock > first_clock:
            self.rate = (time - first_time) / (clock - first_clock)


def state(session: Session, orders: Orders, pace: Pace, remark: str = "") -> dict[str, Any]:
    """Return what a page shows now, as JSON takes it; `remark` is anything else to say."""
    return {
        "time": round(session.time, 3),
        "rate": _rate(session, orders, pace),
        "asked": rounded(orders.command[:3]),
        "walks": rounded(recent_velocity(session.loop.recorder)),
        "feet": on_ground(session.last("contact_flag")),
        "solver": f"{MODELS[session.tuning.model].title}: {_solver(session)}",
        "source": SOURCES[session.tuning.estimation],
        "aim": orders.aim,
        "warnings": warnings_of(session.loop.recorder, session.loop.humanoid)
        + [remark] * bool(remark),
        "fell": session.fall,
        "force": rounded(session.last("true_force")[:, 2]),
        "tilt": rounded(np.degrees(session.tilt())),
        "push": round(float(np.linalg.norm(np.nan_to_num(session.last("push")))), 1),
    }


def lines(now: dict[str, Any]) -> list[str]:
    """Return a `state` as short lines: rate, speeds, contact, solvers, a fall with its reason."""
    said = [
        f"{now['time']:.1f} s, {now['rate']}",
        f"commanded: {_velocity(now['asked'])}",
        f"measured:  {_velocity(now['walks'])}",
        f"on ground: {now['feet']}",
        now["solver"],
        f"state: {now['source']}",
        f"aim of P: {now['aim']}",
    ]
    said += now["warnings"]
    if now["fell"]:
        said += ["The robot FELL. R: begin again", now["fell"]]
    return said


def _rate(session: Session, orders: Orders, pace: Pace) -> str:
    if session.fall:
        return "fallen"
    if orders.paused:
        return "paused"
    slow = "" if pace.keeps_up else ", too slow"
    return f"{pace.rate * orders.speed:.2f} x real time{slow}"


def _velocity(velocity: Iterable[float | None]) -> str:
    return "  ".join(f"{value or 0.0:.2f}" for value in velocity)


def _solver(session: Session) -> str:
    """Return whether MPC and whole-body controller are solved now, and failures so far."""
    mpc, wbc = session.last("mpc_success"), session.last("wbc_success")
    failures = np.nan_to_num(session.last("mpc_failures"))
    names = [name for name, flag in (("MPC", mpc), ("WBC", wbc)) if flag < 0.5]
    said = f"{', '.join(names)} NOT solved" if names else "solved"
    return f"{said}, {int(failures)} failed"
