"""The loop of a drive: look at the controls, do what they ask, simulate on, say how it goes."""

import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

from pydrake.geometry import Meshcat

from drake_linefoot.drive.pace import Pace
from drake_linefoot.drive.panel import Panel
from drake_linefoot.drive.session import Session
from drake_linefoot.drive.status import status
from drake_linefoot.drive.teleop import Orders, Teleop
from drake_linefoot.errors import ScenarioError
from drake_linefoot.scenario import Scenario

PERIOD = 1.0 / 32.0  # [s] between two looks at the controls
SPOKEN = 0.25  # [s] between two looks at what is said on screen


class Drive:
    """A simulation under the controls in Meshcat."""

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
        self._session = Session(scenario, meshcat, record)
        limits = self._session.loop.humanoid.description.limits
        tuning = self._session.tuning
        self._panel = Panel(meshcat, tuning, (limits.com_height_min, limits.com_height_max))
        self._teleop = Teleop(tuning, self._panel.limits)
        self._pace = Pace()
        self._say, self._said, self._remark = say, -1.0, ""

    def run(self, duration: float | None = None) -> Session:
        """Simulate until quit, Ctrl-C or the end of `duration` in wall time [s].

        Returns:
            The session as it was left.
        """
        end = None if duration is None else time.monotonic() + duration
        with _interruptions() as interrupted:
            while not interrupted.is_set() and (end is None or time.monotonic() < end):
                orders = self._teleop.update(self._panel.read(), time.monotonic())
                if orders.quit:
                    break
                self._obey(orders)
                self._simulate(orders)
                self._speak(orders)
        self._panel.remove()
        return self._session

    def _obey(self, orders: Orders) -> None:
        """Do what was asked for."""
        session = self._session
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
        if orders.paused or self._session.fall:
            self._pace.restart()
            time.sleep(PERIOD)
            return
        self._session.advance(PERIOD)
        time.sleep(self._pace.wait(self._session.time, time.monotonic()))

    def _speak(self, orders: Orders) -> None:
        """Say how it goes, some times a second."""
        now = time.monotonic()
        if now < self._said + SPOKEN:
            return
        self._said = now
        lines = status(self._session, orders, self._pace, self._remark)
        self._panel.show(lines)
        if self._say is not None:
            self._say(lines)


@contextmanager
def _interruptions() -> Iterator[threading.Event]:
    """Turn Ctrl-C inside the `with` block into an event; a second one interrupts as ever."""
    event = threading.Event()

    def interrupt(number: int, frame: FrameType | None) -> None:
        event.set()
        signal.signal(signal.SIGINT, before)

    if threading.current_thread() is not threading.main_thread():
        yield event
        return
    before = signal.signal(signal.SIGINT, interrupt)
    try:
        yield event
    finally:
        signal.signal(signal.SIGINT, before)
