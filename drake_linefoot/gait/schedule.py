"""Phases of a walk: when which foot stands, where, and how the other one gets there."""

import math
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from drake_linefoot.gait.ground import line_pitch
from drake_linefoot.gait.state import PITCH, SIZE, YAW
from drake_linefoot.gait.swing import LineMotion, Swing, swing_motion
from drake_linefoot.types import Array, Flags

LEFT, RIGHT = 0, 1
_TIME_EPSILON = 1e-9  # [s]


class Phase(NamedTuple):
    """An interval in which the same feet stand.

    Attributes:
        start, end: [s]; `end` may be infinite.
        contact: whether the left and the right foot stand.
        feet: contact line of each foot, [x, y, z, yaw] in world [m, rad], shape (2, 4);
            of a swing foot, where it will land.
        swing: motion of the swing foot; None when both feet stand.
    """

    start: float
    end: float
    contact: tuple[bool, bool]
    feet: Array
    swing: Swing | None = None

    @property
    def swing_side(self) -> int | None:
        """Side of the swing foot, or None when both feet stand."""
        return None if all(self.contact) else self.contact.index(False)


@dataclass(frozen=True)
class Schedule:
    """Consecutive phases from now to beyond the horizon.

    Attributes:
        phases: the first contains the present time.
        slope: of the ground, rise per metre along x and y of the world, shape (2,).
    """

    phases: tuple[Phase, ...] = field(repr=False)
    slope: Array = field(default_factory=lambda: np.zeros(2))

    @cached_property
    def _ends(self) -> Array:
        """When the phases end, all but the last [s]."""
        return np.array([phase.end for phase in self.phases[:-1]]) - _TIME_EPSILON

    def knots(self, t: float, count: int, step: float) -> Array:
        """Return knot times at most `step` apart such that no phase ends between two.

        Args:
            t: first knot [s].
            count: number of intervals, at least 1.
            step: longest interval [s], positive.

        Returns:
            Increasing times [s], shape (count + 1,).

        Raises:
            ValueError: `count` is below 1 or `step` is not positive.
        """
        if count < 1 or not step > 0.0:
            raise ValueError(f"horizon of {count} knots of {step} s: both must be positive")
        times, number, ends = [t], 0, self._ends.tolist()
        while len(times) <= count:
            now = times[-1]
            while number < len(ends) and ends[number] <= now:
                number += 1
            remaining = self.phases[number].end - now
            if math.isinf(remaining):
                pieces, length = count, step
            else:
                pieces = max(1, math.ceil(remaining / step - 1e-6))
                length = remaining / pieces
            times.extend(now + length * (i + 1) for i in range(pieces))
        return np.array(times[: count + 1])

    def contacts(self, times: Array) -> Flags:
        """Return which feet stand at `times` [s], shape (n, 2)."""
        contacts = np.array([phase.contact for phase in self.phases])
        return contacts[self._ends.searchsorted(times, side="right")]

    def feet_motion(self, times: Array) -> LineMotion:
        """Return the motion of both contact lines at increasing times.

        Args:
            times: [s], shape (n,).

        Returns:
            Positions, velocities and accelerations, shape (2, n, 5) each.
        """
        motion = np.zeros((3, 2, len(times), SIZE))
        starts = [0, *times.searchsorted(self._ends).tolist(), len(times)]
        for phase, (first, end) in zip(self.phases, pairwise(starts), strict=True):
            rows = slice(first, end)
            for side in (LEFT, RIGHT) if first < end else ():
                if phase.swing is not None and phase.swing_side == side:
                    motion[:, side, rows] = swing_motion(phase.swing, times[rows])
                else:
                    motion[0, side, rows, :3] = phase.feet[side, :3]
                    motion[0, side, rows, YAW] = phase.feet[side, 3]
                    motion[0, side, rows, PITCH] = line_pitch(self.slope, phase.feet[side, 3])
        return LineMotion(*motion)
