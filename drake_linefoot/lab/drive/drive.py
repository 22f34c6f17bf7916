"""The loop of a drive: look at the controls, do what they ask, simulate on, say how it goes."""

import threading
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from drake_linefoot.errors import LinefootError, ScenarioError
from drake_linefoot.lab.drive import teleop
from drake_linefoot.lab.drive.panel import MORE, Panel
from drake_linefoot.lab.drive.session import Session
from drake_linefoot.lab.drive.telemetry import Pace, lines, rate_of, state
from drake_linefoot.lab.drive.teleop import Orders, Teleop
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.simulation.interruption import Interruption, interruptions
from drake_linefoot.lab.simulation.recording import LOG, Run
from drake_linefoot.lab.visualization.controls import page_setup
from drake_linefoot.lab.visualization.live import Live
from drake_linefoot.lab.visualization.replay import draw_replay, rounded

PERIOD = 1.0 / 32.0  # [s] between two looks at the controls
SPOKEN = 0.25  # [s] between two looks at what is said in the terminal
REPLAY = "replay.html"  # of a clip


class Drive:
    """A simulation under the controls of its pages.

    Attributes:
        session: what is simulated.
        interrupted: by Ctrl-C or SIGTERM.
    """

    def __init__(
        self,
        scenario: Scenario,
        page: Live,
        *,
        record: bool = False,
        say: Callable[[list[str]], None] | None = None,
    ) -> None:
        """Put the robot at its start and show the controls.

        Args:
            scenario: robot, scene and parameters; its segments are not played.
            page: shows robot and controls; opened by the calling thread.
            record: keep everything, for the session's `run`.
            say: called with the lines for a terminal, some times a second.
        """
        self.session = Session(scenario, page.meshcat, record)
        humanoid, tuning = self.session.loop.humanoid, self.session.tuning
        self._panel = Panel(tuning, humanoid)
        self._teleop = Teleop(tuning, self._panel.limits)
        self._pace, self._speed = Pace(), 1.0
        self._say, self._said, self._remark = say, -1.0, ""
        self._link, self._clip = page.link, Clip(page.link.files)
        self.interrupted = Interruption()
        title = f"{humanoid.description.name}, a drive"
        controls = self._panel.sliders, self._panel.buttons
        self._link.show(
            "setup", page_setup(title, humanoid, *controls, scenario=scenario, more=MORE)
        )

    def run(self, duration: float | None = None) -> Session:
        """Simulate until quit, Ctrl-C, SIGTERM or the end of `duration` in wall time [s].

        Returns:
            The session as it was left.
        """
        end = None if duration is None else time.monotonic() + duration
        with interruptions() as self.interrupted:
            while not self.interrupted and (end is None or time.monotonic() < end):
                seen = self._panel.read(self._link.orders())
                orders = self._teleop.update(seen, time.monotonic())
                if orders.quit:
                    break
                self._obey(orders)
                self._simulate(orders)
                self._speak(orders)
        self._link.show("state", {"ended": True})
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
        if orders.push is not None:
            session.push(orders.push)
        if orders.pull is not None:
            session.pull(orders.pull, 2.0 * PERIOD)
        if orders.record:
            self._clip.toggle(session)
        if orders.tuning is not None:
            try:
                session.retune(orders.tuning)
                self._remark = ""
            except ScenarioError as error:
                self._remark = f"not changed: {error.entry} {error.allowed}"
                # A button that was refused can be pressed again.
                estimation = session.tuning.estimation
                self._teleop.tuning = replace(orders.tuning, estimation=estimation)
            session.command(orders.command)

    def _simulate(self, orders: Orders) -> None:
        """Simulate on in real time, or slower, or wait."""
        if orders.speed != self._speed or (orders.paused and not orders.step) or self.session.fall:
            self._pace.restart()
        self._speed = orders.speed
        if orders.paused and not orders.step:
            time.sleep(PERIOD)
            return
        if self.session.fall:
            self.session.lie_down(PERIOD * orders.speed)
            time.sleep(PERIOD)
            return
        self.session.advance(PERIOD if orders.paused else PERIOD * orders.speed)
        time.sleep(self._pace.wait(self.session.time / orders.speed, time.monotonic()))

    def _speak(self, orders: Orders) -> None:
        """Say how it goes: to the pages always, to the terminal some times a second."""
        session, tuning = self.session, self.session.tuning
        now = state(session.loop, session.time, rate_of(session, orders, self._pace), session.fall)
        now |= {"asked": rounded(orders.command[:3]), "aim": orders.aim}
        now["warnings"] += filter(None, [self._remark, self._clip.note])
        now["note"] = ", ".join(now["warnings"])
        on = {teleop.PAUSE: orders.paused, teleop.ESTIMATE: tuning.estimation}
        on |= {teleop.RECORD: session.clip, teleop.MODEL + tuning.model: True, orders.aim: True}
        now |= {"on": [name for name, pressed in on.items() if pressed]}
        now |= {"values": self._panel.values(), "files": self._clip.files}
        self._link.show("state", now)
        if self._say is not None and time.monotonic() >= self._said + SPOKEN:
            self._said = time.monotonic()
            self._say(lines(now))


class Clip:
    """Records a part of a drive and writes it while the drive goes on, to be downloaded.

    Attributes:
        note: what it is doing; empty when it does nothing.
        files: names of what can be downloaded.
    """

    def __init__(self, folder: Path) -> None:
        self._folder, self.note = folder, ""
        self.files: list[str] = []
        self._writing: threading.Thread | None = None

    def toggle(self, session: Session) -> None:
        """Begin to record, or end it and write what was recorded; nothing while it is written."""
        if self._writing is not None and self._writing.is_alive():
            return
        if not session.clip:
            session.begin_clip()
            self.note = "recording"
            return
        run = session.end_clip()
        if not len(run.time):
            self.note = "nothing was recorded"
            return
        self.note, self.files = "writing the recording", []
        self._writing = threading.Thread(target=self._write, args=(run,), daemon=True)
        self._writing.start()

    def _write(self, run: Run) -> None:
        log, replay = self._folder / LOG, self._folder / REPLAY
        try:
            run.save(log)
            self.files, self.note = [LOG], "drawing the replay"
            draw_replay(log, replay)
            self.files, self.note = [LOG, REPLAY], ""
        except LinefootError as error:
            self.note = str(error)
