"""The robot's end, in a closed loop: the controller is somebody who answers over LCM."""

import time
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np
from pydrake.systems.framework import Context, DiscreteValues

from drake_linefoot.errors import RemoteError
from drake_linefoot.lab.remote.messages import DAMP, RobotInput, RobotOutput, WalkCommand
from drake_linefoot.leaf_system import Block, weak
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.types import Array

SILENCE = 0.02  # [s] of the robot's time without an answer, after which joints are braked
AGAIN = 0.2  # [s] after which a state without an answer is sent once more
PATIENCE = 120.0  # [s] for the first answer: the controller may have to compile
LOCKSTEP_PATIENCE = 10.0  # [s] for any other, where the robot waits for each


class Line(Protocol):
    """What carries messages, such as a `Bus`."""

    def publish(self, message: tuple[Any, ...]) -> None:
        """Send one."""

    def wait(self, timeout: float) -> None:
        """Take in what has come [s]."""

    def take(self, kind: type[RobotInput]) -> RobotInput | None:
        """Return the newest answer."""


class RemoteController(Block):
    """Tells a controller elsewhere the state, and applies what it answers.

    .. pydrake_system::

        name: RemoteController
        input_ports:
        - state
        - applied_torque
        - command
        - angular_velocity
        - specific_force
        output_ports:
        - torque

    In lockstep it waits for the answer to each state, and the torques are those of a controller in
    the loop, to the bit. Otherwise the newest answer holds, that of a state before; after 20 ms
    without one, and where it says so, joints are braked.

    Attributes:
        late: ticks without a new answer, where it does not wait.
        braked: ticks in which joints were braked.
    """

    def __init__(
        self,
        humanoid: Humanoid,
        line: Line,
        period: float = 0.001,
        lockstep: bool = False,
        clock: Callable[[], float] = time.perf_counter,
    ) -> None:
        """Declare ports, state and events.

        Args:
            humanoid: the robot.
            line: over which messages go.
            period: of the ticks [s].
            lockstep: whether to wait for each answer.
            clock: of the patience for answers [s].
        """
        super().__init__()
        self.set_name("controller")
        self._line, self._period, self._lockstep, self._clock = line, period, lockstep, clock
        self._nq, self._rates = humanoid.nq, humanoid.nq + humanoid.actuated_v
        self._damping: Array = humanoid.effort_limits / humanoid.velocity_limits
        self._newest: RobotInput | None = None
        self._heard, self.late, self.braked = 0, 0, 0
        self._state = self.DeclareVectorInputPort("state", humanoid.nq + humanoid.nv)
        self._applied = self.DeclareVectorInputPort("applied_torque", humanoid.na)
        self._command = self.DeclareVectorInputPort("command", 4)
        imu = "angular_velocity", "specific_force"
        self._imu = [self.DeclareVectorInputPort(name, 3) for name in imu]
        held = self.DeclareDiscreteState(humanoid.na)
        self.DeclareStateOutputPort("torque", held)
        self.DeclareInitializationDiscreteUpdateEvent(weak(self, self._begin))
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, weak(self, self._update))

    def _begin(self, context: Context, discrete: DiscreteValues) -> None:
        # Before the first step no torque has been applied, and no acceleration felt.
        state = self._said(context, 0, np.zeros(len(self._damping)), np.zeros(6))
        discrete.set_value(self._torque(state, self._awaited(state, PATIENCE)))

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        # The plant has stepped already, so the state belongs to the end of this tick.
        tick = round(context.get_time() / self._period)
        velocity, (turn, walk) = np.split(self._command.Eval(context), [2])
        utime = round(1e6 * tick * self._period)
        self._line.publish(WalkCommand(utime, velocity, float(turn), int(walk > 0.5)))
        imu = np.concatenate([port.Eval(context) for port in self._imu])
        state = self._said(context, tick + 1, self._applied.Eval(context), imu)
        patience = LOCKSTEP_PATIENCE if self._lockstep else 0.0
        discrete.set_value(self._torque(state, self._awaited(state, patience)))

    def _said(self, context: Context, seq: int, applied: Array, imu: Array) -> RobotOutput:
        """Return the state as a message."""
        q, v = np.split(self._state.Eval(context), [self._nq])
        return RobotOutput(round(1e6 * seq * self._period), seq, q, v, applied, imu)

    def _awaited(self, state: RobotOutput, patience: float) -> RobotInput | None:
        """Send a state; return the answer to it, or the newest where there is no patience.

        Raises:
            RemoteError: nobody answers in time.
        """
        start = sent = self._clock()
        self._line.publish(state)
        while True:
            self._line.wait(min(AGAIN, patience))
            answer = self._line.take(RobotInput)
            now = self._clock()
            if answer is not None and len(answer.effort) == len(self._damping):
                self._newest, self._heard = answer, state.utime
            elif not patience:
                self.late += 1
            if not patience or (answer is not None and answer.seq == state.seq):
                return self._newest
            if now - start > patience:
                raise RemoteError(f"no controller has answered for {patience:g} s")
            if now - sent > AGAIN:
                sent = now
                self._line.publish(state)

    def _torque(self, state: RobotOutput, answer: RobotInput | None) -> Array:
        """Return the torques of an answer, or what brakes the joints, shape (na,)."""
        silent = state.utime - self._heard > 1e6 * SILENCE
        if answer is not None and answer.mode != DAMP and not silent:
            return answer.effort
        self.braked += 1
        x = np.concatenate([state.position, state.velocity])
        brakes: Array = -self._damping * x[self._rates]
        return brakes
