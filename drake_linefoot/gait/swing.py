"""The swing foot: a motion of five coordinates, continuous with two derivatives.

The coordinates are ``[x, y, z, pitch, yaw]`` of the contact line: its middle in world and
its direction. Height is a quintic between the two ground heights plus a smooth bump; all
else is a quintic that starts at the present reference, so that a target that moves while
the foot is in the air bends the motion without a jump.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.gait import swing_kernels
from drake_linefoot.gait.swing_kernels import SIZE

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LineMotion:
    """Motion of a contact line at one or more times.

    Attributes:
        position: [x, y, z, pitch, yaw] [m, rad], shape (..., 5).
        velocity: its rate, shape (..., 5).
        acceleration: its second derivative, shape (..., 5).
    """

    position: Array
    velocity: Array
    acceleration: Array


@dataclass(frozen=True)
class Swing:
    """A swing in progress.

    Attributes:
        start: lift-off [s].
        end: planned touchdown [s].
        now: time at which `reference` holds [s].
        reference: position, velocity, acceleration without the bump, shape (3, 5).
        target: landing position [x, y, z, pitch, yaw], shape (5,).
        height: apex above the ground [m].
        settle: how long before `end` all but the height has arrived [s], so that a foot
            that touches the ground a little early stands where it should.
    """

    start: float
    end: float
    now: float
    reference: Array
    target: Array
    height: float
    settle: float

    def base_motion(self, times: Array) -> Array:
        """Return the motion without the bump at `times` [s] (n,), shape (3, n, 5)."""
        remaining = self.end - self.settle - self.now
        return swing_kernels.base_motion(self.reference, self.target, remaining, times - self.now)

    def motion(self, times: Array) -> LineMotion:
        """Return the motion at `times` [s], shape (n,), between `now` and `end`."""
        motion = self.base_motion(times)
        duration = self.end - self.start
        swing_kernels.add_bump(motion, self.height, duration, times - self.start)
        return LineMotion(*motion)


def line_turn(position: Array, velocity: Array, acceleration: Array) -> tuple[Array, Array, Array]:
    """Return direction, angular velocity and angular acceleration of contact lines.

    Args:
        position: [x, y, z, pitch, yaw], shape (..., 5).
        velocity: its rate, shape (..., 5).
        acceleration: its second derivative, shape (..., 5).

    Returns:
        (d, w, alpha) in world: unit vectors, [rad/s], [rad/s^2], each (..., 3).
    """
    motion = np.stack([position, velocity, acceleration]).reshape(3, -1, SIZE)
    d, w, alpha = swing_kernels.line_turn(motion).reshape(3, *position.shape[:-1], 3)
    return d, w, alpha
