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

from drake_linefoot.math.polynomials import bump, quintic

Array = NDArray[np.float64]

SIZE = 5
Z, PITCH, YAW = 2, 3, 4


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

    def base_motion(self, times: Array) -> tuple[Array, Array, Array]:
        """Return the motion without the bump at `times` [s] (...), each (..., 5)."""
        remaining = self.end - self.settle - self.now
        if remaining <= 1e-9:
            shape = (*times.shape, SIZE)
            zero = np.zeros(shape)
            return np.broadcast_to(self.reference[0], shape).copy(), zero, zero.copy()
        goal = np.zeros((3, SIZE))
        goal[0] = self.target
        return quintic(self.reference, goal, remaining, times - self.now)

    def motion(self, times: Array) -> LineMotion:
        """Return the motion at `times` [s], shape (...), between `now` and `end`."""
        return self._with_bump(times, *self.base_motion(times))

    def present(self) -> LineMotion:
        """Return the motion at `now`, shapes (5,)."""
        return self._with_bump(np.array(self.now), *self.reference.copy())

    def _with_bump(self, times: Array, p: Array, v: Array, a: Array) -> LineMotion:
        """Add the bump to a motion without it, in place."""
        b, db, ddb = bump(self.height, self.end - self.start, times - self.start)
        p[..., Z] += b
        v[..., Z] += db
        a[..., Z] += ddb
        return LineMotion(p, v, a)


def line_direction(pitch: Array, yaw: Array) -> Array:
    """Return the unit direction of a contact line, shape (..., 3).

    Args:
        pitch: toe down positive [rad], shape (...).
        yaw: heading [rad], shape (...).
    """
    d, c = np.empty((*np.shape(yaw), 3)), np.cos(pitch)
    d[..., 0], d[..., 1], d[..., 2] = np.cos(yaw) * c, np.sin(yaw) * c, -np.sin(pitch)
    return d


def line_turn(position: Array, velocity: Array, acceleration: Array) -> tuple[Array, Array, Array]:
    """Return direction, angular velocity and angular acceleration of a contact line.

    The line has no roll of its own, so the angular velocity is the one of
    ``rot_z(yaw) rot_y(pitch)``.

    Args:
        position: [x, y, z, pitch, yaw], shape (..., 5).
        velocity: its rate, shape (..., 5).
        acceleration: its second derivative, shape (..., 5).

    Returns:
        (d, w, alpha) in world: unit vectors, [rad/s], [rad/s^2], each (..., 3).
    """
    cosine, sine = np.cos(position[..., YAW]), np.sin(position[..., YAW])
    dp, dy = velocity[..., PITCH], velocity[..., YAW]
    ddp = acceleration[..., PITCH]
    w, alpha = np.empty((*dp.shape, 3)), np.empty((*dp.shape, 3))
    w[..., 0], w[..., 1], w[..., 2] = -sine * dp, cosine * dp, dy
    alpha[..., 0] = -sine * ddp - cosine * dp * dy
    alpha[..., 1] = cosine * ddp - sine * dp * dy
    alpha[..., 2] = acceleration[..., YAW]
    return line_direction(position[..., PITCH], position[..., YAW]), w, alpha
