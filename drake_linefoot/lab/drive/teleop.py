"""From keys, sliders and sticks to commands: what a driver's inputs mean, without any display."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from drake_linefoot.types import Array

# What can be pressed.
STOP, PUSH, PAUSE, RESET, QUIT = "stop", "push", "pause", "reset", "quit"
STEP, RECORD, ESTIMATE = "step", "record", "estimate"
AIMS = {  # direction of the push in the heading frame: forward, left
    "push forward": (1.0, 0.0),
    "push backward": (-1.0, 0.0),
    "push left": (0.0, 1.0),
    "push right": (0.0, -1.0),
}
MODEL = "model "  # before the name of a model to change to

SETTLED = 0.4  # [s] a slider must rest before what it changes is changed
DEAD_ZONE = 0.15  # [-] of a stick


@dataclass(frozen=True)
class Tuning:
    """What can be changed while the robot walks."""

    single_support: float  # step time less the double support [s]
    swing_height: float  # [m]
    com_height: float  # [m] above the stance foot
    model: str  # of the MPC, see `MpcParameters`
    estimation: bool = False  # whether it walks on the estimate of its state, not on the truth


class Seen(NamedTuple):
    """What the driver did since the last look."""

    pressed: tuple[str, ...]  # keys and buttons, in any order; a name may come more than once
    velocity: Array  # sliders forward, left [m/s], turn [rad/s], shape (3,)
    lengths: tuple[float, float, float]  # sliders single support [s], swing height, CoM height [m]
    force: float  # slider of the push [N]
    stick: Array | None = None  # gamepad, forward, left, turn in [-1, 1], shape (3,)
    speed: float = 1.0  # of the simulation [-], 1 is real time
    pull: Array | None = None  # force of the pointer's spring in W [N], shape (3,)


class Orders(NamedTuple):
    """What is to be done."""

    command: Array  # v_x, v_y [m/s], turn rate [rad/s], walk (0 or 1), shape (4,)
    push: Array | None  # force in the heading frame, forward and left [N], shape (2,)
    pull: Array | None  # force of the pointer's spring in W [N], shape (3,)
    tuning: Tuning | None  # what to change to; None when nothing changes
    sliders: Array | None  # where to move the velocity sliders, shape (3,); None to leave them
    reset: bool  # begin again
    quit: bool  # end
    paused: bool  # stand still in time
    step: bool  # go on by one picture, when paused
    record: bool  # begin a recording, or end it
    aim: str  # name of the push's direction
    speed: float  # of the simulation [-], 1 is real time


@dataclass
class Teleop:
    """Turns what the driver does into orders.

    A velocity that is not zero makes the robot walk; a velocity brought back to zero lets it
    step in place; stop makes it stand. A stick that is moved goes before the sliders. Reset
    also stops. Sliders of gait and height count when they have rested for 0.4 s.

    Attributes:
        tuning: in force.
        limits: least and largest velocity of a stick, forward, left [m/s], turn [rad/s],
            shape (2, 3).
    """

    tuning: Tuning
    limits: ArrayLike
    _walk: bool = False
    _paused: bool = False
    _aim: str = "push forward"
    _velocity: Array = field(default_factory=lambda: np.zeros(3))
    _wanted: Tuning | None = None
    _since: float = 0.0

    def update(self, seen: Seen, clock: float) -> Orders:
        """Return the orders at `clock` [s], wall time."""
        if not np.array_equal(seen.velocity, self._velocity):
            self._velocity = seen.velocity.copy()
            self._walk = self._walk or bool(np.any(seen.velocity))
        stop = STOP in seen.pressed or RESET in seen.pressed
        if stop:
            self._walk, self._velocity = False, np.zeros(3)
        for name in seen.pressed:
            self._aim = name if name in AIMS else self._aim
        if seen.pressed.count(PAUSE) % 2:
            self._paused = not self._paused
        if RESET in seen.pressed:
            self._paused = False
        elif STEP in seen.pressed:
            self._paused = True
        return Orders(
            command=self._command(seen.stick),
            push=seen.force * np.array(AIMS[self._aim]) if PUSH in seen.pressed else None,
            tuning=self._retune(seen, clock),
            sliders=np.zeros(3) if stop else None,
            reset=RESET in seen.pressed,
            quit=QUIT in seen.pressed,
            paused=self._paused,
            aim=self._aim,
            speed=seen.speed,
            pull=seen.pull,
            step=STEP in seen.pressed,
            record=seen.pressed.count(RECORD) % 2 == 1,
        )

    def _command(self, stick: Array | None) -> Array:
        velocity = self._velocity
        if stick is not None:
            beyond = np.maximum(np.abs(stick) - DEAD_ZONE, 0.0) / (1.0 - DEAD_ZONE)
            if beyond.any():
                self._walk = True
                least, largest = np.asarray(self.limits)
                velocity = np.minimum(beyond, 1.0) * np.where(stick < 0.0, least, largest)
        return np.array([*velocity, float(self._walk)])

    def _retune(self, seen: Seen, clock: float) -> Tuning | None:
        """Return a new tuning when one is asked for and has rested."""
        model = self.tuning.model
        for name in seen.pressed:
            model = name.removeprefix(MODEL) if name.startswith(MODEL) else model
        estimation = self.tuning.estimation ^ (seen.pressed.count(ESTIMATE) % 2 == 1)
        wanted = Tuning(*seen.lengths, model, estimation)
        if wanted != self._wanted:
            self._wanted, self._since = wanted, clock
        now = self.tuning
        pressed = (model, estimation) != (now.model, now.estimation)
        if wanted == self.tuning or not (pressed or clock >= self._since + SETTLED):
            return None
        self.tuning = wanted
        return wanted
