"""The controller's end: it answers what a robot says, whatever that is."""

import time
from collections.abc import Callable
from itertools import repeat

import numpy as np

from drake_linefoot.errors import LinefootError, SignalError
from drake_linefoot.lab.remote.bus import Bus
from drake_linefoot.lab.remote.messages import (
    DAMP,
    HOLD,
    ControllerStatus,
    RobotInput,
    RobotOutput,
    WalkCommand,
)
from drake_linefoot.types import Array
from drake_linefoot.wiring.without_simulator import STAND, Controller

SILENT_COMMAND = 500_000  # [us] after which a walk stops
MOST_REPEATED = 20  # ticks that were missed; after more it begins anew
MOST_REFUSED = 3  # states in a row that cannot be used; then the joints are braked
STATUS_PERIOD = 0.1  # [s]


class RemoteControl:
    """Makes an answer of each state.

    * A state with a number that is not finite is refused, and the last torque holds; from the third
      in a row on, and after an error of the controller, joints are braked.
    * A state of another size is refused: there is no answer to it.
    * A state that is older than one before is dropped; the same once more gets the same answer.
    * Up to 20 that are missing are taken as the one that came; after more it begins anew, with
      both feet on the ground, as it does when the robot counts from 0 again.
    * A command that is half a second old is one to stand.
    """

    def __init__(self, controller: Controller) -> None:
        """Begin with the first state that comes."""
        humanoid = controller.humanoid
        self.controller = controller
        # So that at the speed limit a joint is braked with the effort limit.
        self._damping: Array = humanoid.effort_limits / humanoid.velocity_limits
        self._answer: RobotInput | None = None
        self._command: WalkCommand | None = None
        self._counts = dict.fromkeys(("refused", "old", "missed", "begun"), 0)
        self._in_a_row, self._begun, self._worst, self._fault = 0, False, 0.0, ""

    def command(self, message: WalkCommand) -> None:
        """Take a command, which holds for half a second."""
        if np.isfinite([*message.velocity, message.turn_rate]).all():
            self._command = message

    def answer(self, message: RobotOutput) -> RobotInput | None:
        """Return what the robot is to do; None to a state that gets no answer."""
        start, last = time.perf_counter(), self._answer
        if last is not None and 0 < message.seq <= last.seq:
            if message.seq == last.seq:
                return last
            self._counts["old"] += 1
            return None
        if last is not None and message.seq == last.seq == 0 and message.utime == last.utime:
            return last
        try:
            torque = self._torque(message, last)
        except SignalError as error:
            self._fault = str(error)
            self._counts["refused"] += 1
            self._in_a_row += 1
            if not self._fits(message):
                return None
            brakes = self._in_a_row >= MOST_REFUSED or last is None
            torque = np.zeros(len(self._damping)) if last is None else last.effort
            mode = DAMP if brakes else HOLD
        except (LinefootError, RuntimeError, np.linalg.LinAlgError) as error:
            self._fault, self._begun = str(error), False
            torque, mode = np.zeros(len(self._damping)), DAMP
        else:
            self._in_a_row, self._fault, mode = 0, "", HOLD
        self._answer = RobotInput(message.utime, message.seq, mode, torque, self._damping)
        self._worst = max(self._worst, 1e3 * (time.perf_counter() - start))
        return self._answer

    def _fits(self, message: RobotOutput) -> bool:
        """Whether a state has the sizes of the robot."""
        humanoid = self.controller.humanoid
        size = len(message.position) + len(message.velocity)
        return size == humanoid.nq + humanoid.nv and len(message.effort) == humanoid.na

    def _torque(self, message: RobotOutput, last: RobotInput | None) -> Array:
        x = np.concatenate([message.position, message.velocity])
        missed = 0 if last is None else message.seq - last.seq - 1
        if last is None or not self._begun or missed > MOST_REPEATED or message.seq == 0:
            torque = self.controller.begin(x)
            self._begun = True
            self._counts["begun"] += 1
            return torque
        told = self._told(message.utime)
        for _ in repeat(None, missed + 1):
            torque = self.controller.tick(x, message.effort, told)
        self._counts["missed"] += missed
        return torque

    def _told(self, now: int) -> Array:
        """Return the command that holds [us], as `Controller.tick` takes it."""
        command = self._command
        if command is None or now - command.utime > SILENT_COMMAND:
            return np.array(STAND)
        return np.array([*command.velocity, command.turn_rate, float(command.walk)])

    def status(self) -> ControllerStatus:
        """Return how it is; the worst tick is that since the last call."""
        worst, self._worst = self._worst, 0.0
        utime, seq = (0, 0) if self._answer is None else self._answer[:2]
        contact, unsolved = np.zeros(2), 0
        if self._begun:
            contact = self.controller.look("contact").contact
            unsolved = int(self.controller.look("plan").failures)
        counts = {**self._counts, "unsolved": unsolved}
        return ControllerStatus(utime, seq, contact, worst_tick=worst, fault=self._fault, **counts)


def serve(control: RemoteControl, bus: Bus, stop: Callable[[], object]) -> None:
    """Answer the newest state, tick by tick, and say ten times a second how it is.

    Args:
        control: what answers.
        bus: listens to `RobotOutput` and `WalkCommand`.
        stop: asked a few times a second; it ends when that returns something true.
    """
    said = time.monotonic()
    while not stop():
        bus.wait(STATUS_PERIOD)
        if (command := bus.take(WalkCommand)) is not None:
            control.command(command)
        if (state := bus.take(RobotOutput)) is not None:
            answer = control.answer(state)
            if answer is not None:
                bus.publish(answer)
        if time.monotonic() - said > STATUS_PERIOD:
            said = time.monotonic()
            bus.publish(control.status())
