"""The loop of a drive: look at the controls, do what they ask, simulate on, say how it goes."""

import time
from collections.abc import Callable, Iterable

import numpy as np
from pydrake.geometry import Meshcat

from drake_linefoot.drive.pace import Pace
from drake_linefoot.drive.panel import Panel
from drake_linefoot.drive.session import Session
from drake_linefoot.drive.teleop import Orders, Teleop
from drake_linefoot.errors import ScenarioError
from drake_linefoot.scenario import Scenario
from drake_linefoot.simulation.channels import FEET
from drake_linefoot.simulation.interruption import Interruption, interruptions
from drake_linefoot.simulation.run import recent_velocity

PERIOD = 1.0 / 32.0  # [s] between two looks at the controls
MODELS = {
    "ecd": "ECD",
    "contact_consistent": "contact-consistent",
    "srbm": "single rigid body",
    "srbm_momentum": "single rigid body, whole momentum",
}
SPOKEN = 0.25  # [s] between two looks at what is said on screen


class Drive:
    """A simulation under the controls in Meshcat.

    Attributes:
        session: what is simulated.
        interrupted: by Ctrl-C or SIGTERM.
    """

    def __init__(
        self,
        scenario: Scenario,
        meshcat: Meshcat,
        *,
        record: bool = False,
        say: Callable[[list[str]], None] | None = None,
    ) -> None:
        """Put the robot at its start and show the controls.

        Args:
            scenario: robot, scene and parameters; its segments are not played.
            meshcat: shows robot and controls; made by the calling thread.
            record: keep everything, for the session's `run`.
            say: called with the lines that are on screen whenever they are new.
        """
        self.session = Session(scenario, meshcat, record)
        tuning = self.session.tuning
        self._panel = Panel(meshcat, tuning, self.session.loop.humanoid)
        self._teleop = Teleop(tuning, self._panel.limits)
        self._pace = Pace()
        self._say, self._said, self._remark = say, -1.0, ""
        self.interrupted = Interruption()

    def run(self, duration: float | None = None) -> Session:
        """Simulate until quit, Ctrl-C, SIGTERM or the end of `duration` in wall time [s].

        Returns:
            The session as it was left.
        """
        end = None if duration is None else time.monotonic() + duration
        with interruptions() as self.interrupted:
            while not self.interrupted and (end is None or time.monotonic() < end):
                orders = self._teleop.update(self._panel.read(), time.monotonic())
                if orders.quit:
                    break
                self._obey(orders)
                self._simulate(orders)
                self._speak(orders)
        self._panel.remove()
        return self.session

    def _obey(self, orders: Orders) -> None:
        """Do what was asked for."""
        session = self.session
        if orders.sliders is not None:
            self._panel.move_sliders(orders.sliders)
        if orders.reset:
            session.reset()
            self._pace.restart()
            self._remark = ""
        session.command(orders.command)
        if orders.push is not None and not session.fall:
            session.push(orders.push)
        if orders.tuning is not None:
            try:
                session.retune(orders.tuning)
                self._remark = ""
            except ScenarioError as error:
                self._remark = f"not changed: {error.entry} {error.allowed}"
            session.command(orders.command)

    def _simulate(self, orders: Orders) -> None:
        """Simulate on in real time, or wait."""
        if orders.paused or self.session.fall:
            self._pace.restart()
            time.sleep(PERIOD)
            return
        self.session.advance(PERIOD)
        time.sleep(self._pace.wait(self.session.time, time.monotonic()))

    def _speak(self, orders: Orders) -> None:
        """Say how it goes, some times a second."""
        now = time.monotonic()
        if now < self._said + SPOKEN:
            return
        self._said = now
        lines = status(self.session, orders, self._pace, self._remark)
        self._panel.show(lines)
        if self._say is not None:
            self._say(lines)


def status(session: Session, orders: Orders, pace: Pace, remark: str = "") -> list[str]:
    """Return short lines: rate, speeds, contact, solvers, push, and a fall with its reason.

    Args:
        session: what is simulated.
        orders: in force.
        pace: its rate.
        remark: anything else; empty for nothing.
    """
    lines = [
        f"{session.time:.1f} s, {_rate(session, orders, pace)}",
        f"asked:  {_velocity(orders.command[:3])}",
        f"walks:  {_velocity(recent_velocity(session.loop.recorder))}",
        f"on ground: {_contact(session)}",
        f"{MODELS[session.tuning.model]}: {_solver(session)}",
        f"aim of P: {orders.aim}",
    ]
    if remark:
        lines.append(remark)
    if session.fall:
        lines += ["The robot FELL. R: begin again", session.fall]
    return lines


def _rate(session: Session, orders: Orders, pace: Pace) -> str:
    if session.fall:
        return "fallen"
    if orders.paused:
        return "paused"
    return f"{pace.rate:.2f} x real time{'' if pace.keeps_up else ', too slow'}"


def _velocity(velocity: Iterable[float]) -> str:
    return "  ".join(f"{value + 0.0:.2f}" for value in velocity)


def _contact(session: Session) -> str:
    flags = session.last("contact_flag")
    return " ".join(foot for foot, flag in zip(FEET, flags, strict=True) if flag > 0.5) or "none"


def _solver(session: Session) -> str:
    """Return whether MPC and whole-body controller are solved now, and failures so far."""
    mpc, wbc = session.last("mpc_success"), session.last("wbc_success")
    failures = np.nan_to_num(session.last("mpc_failures"))
    names = [name for name, flag in (("MPC", mpc), ("WBC", wbc)) if flag < 0.5]
    said = f"{', '.join(names)} NOT solved" if names else "solved"
    return f"{said}, {int(failures)} failed"
