"""What the gait remembers from one tick to the next, as a vector and by name."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.gait.swing import SIZE

Array = NDArray[np.float64]


class Mode(IntEnum):
    """What the feet are doing."""

    STAND = 0  # both feet, the DCM is captured between them
    SHIFT = 1  # both feet, the DCM is taken to where the first step can start
    SWING = 2  # `side` stands, the other foot is in the air
    DOUBLE = 3  # both feet, the weight goes over to `side`


_SHAPES: dict[str, tuple[int, ...]] = {
    "time": (),
    "mode": (),
    "side": (),
    "closing": (),
    "phase_start": (),
    "phase_end": (),
    "yaw": (),
    "velocity": (2,),
    "turn_rate": (),
    "speed_scale": (2,),
    "speed_offset": (2,),
    "marks": (2, 3),
    "com": (3,),
    "com_velocity": (3,),
    "feet": (2, 4),
    "target": (SIZE,),
    "reference": (3, SIZE),
    "steps": (),
    "moved_footholds": (),
    "clipped_commands": (),
}

_SIZES = {name: math.prod(shape) for name, shape in _SHAPES.items()}
_INTEGERS = ("mode", "side", "closing", "steps", "moved_footholds", "clipped_commands")


@dataclass(frozen=True)
class GaitState:
    """State of the gait.

    Attributes:
        time: time at which everything below holds [s].
        mode: a `Mode`.
        side: the stance foot, or in double support the foot the weight goes to.
        closing: 1 when the swing foot is being put beside the other to stand.
        phase_start, phase_end: present phase [s].
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
    steps: int = 0
    moved_footholds: int = 0
    clipped_commands: int = 0

    def to_vector(self) -> Array:
        """Return all fields in one vector, shape (GaitState.size(),)."""
        vector, at = np.empty(self.size()), 0
        for name, size in _SIZES.items():
            value = getattr(self, name)
            vector[at : at + size] = value if size == 1 else value.ravel()
            at += size
        return vector

    @staticmethod
    def size() -> int:
        """Return the length of the vector form."""
        return sum(_SIZES.values())

    @classmethod
    def from_vector(cls, vector: Array) -> GaitState:
        """Return the state that `to_vector` made `vector` of."""
        values: dict[str, object] = {}
        at = 0
        for name, shape in _SHAPES.items():
            end = at + _SIZES[name]
            values[name] = vector[at:end].reshape(shape).copy() if shape else float(vector[at])
            at = end
        for name in _INTEGERS:
            values[name] = int(values[name])  # type: ignore[call-overload]
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
        if not changes.keys() <= _SHAPES.keys():
            raise TypeError(f"no fields of a gait state: {sorted(changes.keys() - _SHAPES.keys())}")
        copy = object.__new__(GaitState)
        copy.__dict__.update(self.__dict__, **changes)
        return copy


assert set(_SHAPES) == {f.name for f in fields(GaitState)}
