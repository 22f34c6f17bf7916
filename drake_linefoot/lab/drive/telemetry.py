"""How a drive goes: its pace, numbers for its pages, and lines for the terminal."""

import time as clock
from collections import deque
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from pydrake.systems.framework import Context

from drake_linefoot.lab.drive.session import Session
from drake_linefoot.lab.drive.teleop import Orders
from drake_linefoot.lab.simulation.closed_loop import ClosedLoop
from drake_linefoot.lab.simulation.recorder import Recorder
from drake_linefoot.lab.simulation.velocity import recent_velocity
from drake_linefoot.lab.simulation.warnings import warnings_of
from drake_linefoot.lab.visualization.controls import page_setup
from drake_linefoot.lab.visualization.live import Link
from drake_linefoot.lab.visualization.overlays import PERIOD
from drake_linefoot.lab.visualization.replay import SOURCES, on_ground, rounded
from drake_linefoot.math.rotation import roll_pitch_yaw
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


def state(loop: ClosedLoop, time: float, rate: str, fell: str = "") -> dict[str, Any]:
    """Return what a page shows of a loop's last sample at `time` [s], as JSON takes it.

    Args:
        loop: what is simulated.
        time: now [s].
        rate: of the simulation, in words.
        fell: why the robot fell; empty when it stands.
    """
    recorder, scenario = loop.recorder, loop.scenario
    warnings = warnings_of(recorder, loop.humanoid)
    return {
        "time": round(time, 3),
        "rate": rate,
        "asked": rounded(recorder.last("command")[:3]),
        "walks": rounded(recent_velocity(recorder)),
        "feet": on_ground(recorder.last("contact_flag")),
        "solver": f"{MODELS[scenario.mpc.model].title}: {_solver(recorder)}",
        "source": SOURCES[scenario.estimation],
        "warnings": warnings,
        "note": ", ".join(warnings),
        "fell": fell,
        "force": rounded(recorder.last("true_force")[:, 2]),
        "tilt": rounded(np.degrees(roll_pitch_yaw(recorder.last("q")[:4])[:2])),
        "push": round(float(np.linalg.norm(np.nan_to_num(recorder.last("push")))), 1),
        "on": [],
        "values": {},
        "files": [],
    }


def follow(loop: ClosedLoop, link: Link, title: str) -> Callable[[Context], None]:
    """Show a loop that is simulated to its live pages; return what is called after every step."""
    link.show("setup", page_setup(title, loop.humanoid, scenario=loop.scenario))
    pace, due = Pace(), [0.0]

    def look(context: Context) -> None:
        time = context.get_time()
        if time < due[0] - PERIOD:  # it has begun anew
            pace.restart()
        elif time < due[0]:
            return
        due[0] = time + PERIOD
        pace.wait(time, clock.monotonic())
        link.show("state", state(loop, time, f"{pace.rate:.2f} x real time"))

    return look


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


def rate_of(session: Session, orders: Orders, pace: Pace) -> str:
    """Return how fast a drive goes, in words."""
    if session.fall:
        return "fallen"
    if orders.paused:
        return "paused"
    slow = "" if pace.keeps_up else ", too slow"
    return f"{pace.rate * orders.speed:.2f} x real time{slow}"


def _velocity(velocity: Iterable[float | None]) -> str:
    return "  ".join(f"{value or 0.0:.2f}" for value in velocity)


def _solver(recorder: Recorder) -> str:
    """Return whether MPC and whole-body controller are solved now, and failures so far."""
    mpc, wbc = recorder.last("mpc_success"), recorder.last("wbc_success")
    failures = int(np.nan_to_num(recorder.last("mpc_failures")))
    names = [name for name, flag in (("MPC", mpc), ("WBC", wbc)) if flag < 0.5]
    said = f"{', '.join(names)} NOT solved" if names else "solved"
    return f"{said}, {failures} failed"
