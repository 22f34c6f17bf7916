"""What the gait remembers from one tick to the next, as a vector and by name."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from enum import IntEnum
from operator import attrgetter

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.gait import tick_kernels
from drake_linefoot.gait.swing_kernels import SIZE

Array = NDArray[np.float64]


class Mode(IntEnum):
    """What the feet are doing."""

    STAND = tick_kernels.STAND  # both feet, the DCM is captured between them
    SHIFT = tick_kernels.SHIFT  # both feet, the DCM is taken to where the first step can start
    SWING = tick_kernels.SWING  # `side` stands, the other foot is in the air
    DOUBLE = tick_kernels.DOUBLE  # both feet, the weight goes over to `side`


_NUMBERS = (
    "time",
    "mode",
    "side",
    "closing",
    "phase_start",
    "phase_end",
    "due",
    "yaw",
    "turn_rate",
    "steps",
    "moved_footholds",
    "clipped_commands",
)
_INTEGERS = ("mode", "side", "closing", "steps", "moved_footholds", "clipped_commands")
_SHAPES: dict[str, tuple[int, ...]] = {  # of the arrays
    "velocity": (2,),
    "speed_scale": (2,),
    "speed_offset": (2,),
    "marks": (2, 3),
    "com": (3,),
    "com_velocity": (3,),
    "feet": (2, 4),
    "target": (SIZE,),
    "reference": (3, SIZE),
    "slope": (2,),
}
_FIELDS = len(_NUMBERS) + len(_SHAPES)
_SIZE = len(_NUMBERS) + sum(map(math.prod, _SHAPES.values()))
_numbers_of, _arrays_of = attrgetter(*_NUMBERS), attrgetter(*_SHAPES)


@dataclass(frozen=True)
class GaitState:
    """State of the gait.

    Attributes:
        time: time at which everything below holds [s].
        mode: a `Mode`.
        side: the stance foot, or in double support the foot the weight goes to.
        closing: 1 when the swing foot is being put beside the other to stand.
        phase_start, phase_end: present phase [s].
        due: when the swing foot is, or was, to land [s]; a late one moves `phase_end`.
        yaw: desired heading [rad].
        velocity: commanded velocity after rate limits, heading frame [m/s], shape (2,).
        turn_rate: commanded turn rate after rate limits [rad/s].
        speed_scale: by which the commanded velocity is multiplied when footholds are
            chosen, learned from the speed that came of it [-], shape (2,).
        speed_offset: added to it, likewise learned [m/s], shape (2,).
        marks: [time, x, y] of the CoM at the last two touchdowns, newest first; time is
            negative where there is none, shape (2, 3).
        com, com_velocity: measured CoM [m, m/s], shape (3,).
        feet: contact lines [x, y, z, yaw], measured while they stand, shape (2, 4).
        target: where the swing foot will land [x, y, z, pitch, yaw], shape (5,).
        reference: swing motion now without the bump, shape (3, 5).
        slope: of the ground, estimated: rise per metre along x and y of the world, shape (2,).
        steps: steps taken so far.
        moved_footholds: ticks in which a limit moved the foothold.
        clipped_commands: commands that were outside their limits so far.
    """

    time: float
    mode: int
    side: int
    closing: int
    phase_start: float
    phase_end: float
    due: float
    yaw: float
    velocity: Array
    turn_rate: float
    speed_scale: Array
    speed_offset: Array
    marks: Array
    com: Array
    com_velocity: Array
    feet: Array
    target: Array
    reference: Array
    slope: Array
    steps: int = 0
    moved_footholds: int = 0
    clipped_commands: int = 0

    def to_vector(self) -> Array:
        """Return all fields in one vector, numbers before arrays, shape (GaitState.size(),)."""
        return np.concatenate((_numbers_of(self), *_arrays_of(self)), axis=None, dtype=float)

    @staticmethod
    def size() -> int:
        """Return the length of the vector form."""
        return _SIZE

    @classmethod
    def from_vector(cls, vector: Array) -> GaitState:
        """Return the state that `to_vector` made `vector` of."""
        at = len(_NUMBERS)
        values: dict[str, object] = dict(zip(_NUMBERS, vector[:at].tolist(), strict=True))
        for name in _INTEGERS:
            values[name] = int(values[name])  # type: ignore[call-overload]
        for name, shape in _SHAPES.items():
            end = at + math.prod(shape)
            values[name] = vector[at:end].reshape(shape).copy()
            at = end
        return cls(**values)  # type: ignore[arg-type]

    @property
    def swing_side(self) -> int:
        """The foot that is not `side`."""
        return 1 - self.side

    @property
    def contact(self) -> tuple[bool, bool]:
        """Whether the left and the right foot stand."""
        if self.mode != Mode.SWING:
            return True, True
        return (self.side == 0, self.side == 1)

    def changed(self, **changes: object) -> GaitState:
        """Return a copy with some fields changed; raise TypeError for what is no field.

        As dataclasses.replace, which takes five times as long.
        """
        copy = object.__new__(GaitState)
        copy.__dict__.update(self.__dict__, **changes)
        if len(copy.__dict__) != _FIELDS:
            unknown = sorted(copy.__dict__.keys() - self.__dict__.keys())
            raise TypeError(f"no fields of a gait state: {unknown}")
        return copy


assert {*_NUMBERS, *_SHAPES} == {f.name for f in fields(GaitState)}
