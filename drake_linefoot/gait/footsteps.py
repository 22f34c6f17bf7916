"""Footholds from the divergent component of motion, with reach and crossing limits."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.gait.pendulum import dcm_offset

Array = NDArray[np.float64]

SIDE_SIGN = (1.0, -1.0)  # left foot is at +y of the body, right foot at -y
_STRIDES_AHEAD = 6  # exp(-6 w T) is below 0.5 % for w T = 0.9


@dataclass(frozen=True)
class StepCommand:
    """What the gait is asked to do, in the heading frame.

    Attributes:
        velocity: forward and left [m/s], shape (2,).
        turn_rate: counter-clockwise [rad/s].
    """

    velocity: Array
    turn_rate: float


@dataclass(frozen=True)
class StepShape:
    """The constants of a step.

    Attributes:
        duration: T, from one switch of the CoP to the next [s].
        width: lateral distance between the feet when standing [m].
        omega: natural frequency of the pendulum [1/s].
        length_max: largest forward distance between the feet [m].
        width_min, width_max: smallest and largest lateral distance [m].
    """

    duration: float
    width: float
    omega: float
    length_max: float
    width_min: float
    width_max: float


def heading_vector(yaw: float, forward: float, left: float) -> Array:
    """Return (forward, left) of a heading frame in world, shape (2,)."""
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([c * forward - s * left, s * forward + c * left])


def nominal_strides(
    command: StepCommand, shape: StepShape, yaw: float, side: int, count: int = _STRIDES_AHEAD
) -> Array:
    """Return the strides of a steady walk, from the foot `side` on.

    The path turns with the command; foothold k stands half a width left or right of it.

    Args:
        command: velocity and turn rate, held for all strides.
        shape: duration and width.
        yaw: heading at the first foot [rad].
        side: 0 if the first foot is the left, 1 if the right.
        count: number of strides.

    Returns:
        Displacements in world [m], shape (count, 2).
    """
    turn = command.turn_rate * shape.duration
    # Chord of the arc: the path between two footholds is shorter than v T when it bends.
    half = 0.5 * turn
    chord = shape.duration * (math.sin(half) / half if half else 1.0)
    vx, vy = chord * command.velocity
    # A sideways walk brings the feet nearer every other step: stand wide enough for it.
    width = max(shape.width, shape.width_min + abs(vy))
    # As complex numbers: along the path in the middle of the stride, from side to side at
    # the footholds.
    k = np.arange(count + 1)
    headings = np.exp(1j * (yaw + turn * k))
    aside = (0.5j * width * SIDE_SIGN[side]) * headings
    aside[1::2] *= -1.0
    stride = (complex(vx, vy) * cmath.exp(1j * half)) * headings[:-1] + aside[1:] - aside[:-1]
    return np.stack([stride.real, stride.imag], axis=1)


def clip_foothold(
    foothold: Array, stance: Array, yaw: float, side: int, shape: StepShape
) -> tuple[Array, bool]:
    """Move a foothold to the nearest one the leg can reach without crossing.

    Args:
        foothold: wanted position [m], shape (2,).
        stance: position of the stance foot [m], shape (2,).
        yaw: heading at touchdown [rad].
        side: side of the swing foot, 0 left, 1 right.
        shape: limits.

    Returns:
        (foothold, moved): shape (2,), and whether it had to be moved.
    """
    c, s = math.cos(yaw), math.sin(yaw)
    dx, dy = (foothold - stance).tolist()
    forward, outward = c * dx + s * dy, SIDE_SIGN[side] * (c * dy - s * dx)
    f = min(max(forward, -shape.length_max), shape.length_max)
    o = min(max(outward, shape.width_min), shape.width_max)
    moved = f != forward or o != outward
    if not moved:
        return foothold, False
    return stance + heading_vector(yaw, f, SIDE_SIGN[side] * o), True


def next_foothold(
    xi: Array, stance: Array, yaw: float, side: int, command: StepCommand, shape: StepShape
) -> tuple[Array, bool]:
    """Return the foothold that the DCM at the switch of the CoP asks for.

    Args:
        xi: DCM predicted for the moment the weight comes onto the new foot [m], shape (2,).
        stance: the present stance foot [m], shape (2,).
        yaw: heading at touchdown [rad].
        side: side of the new foot.
        command: what is commanded.
        shape: constants and limits.

    Returns:
        (foothold, moved): shape (2,), and whether a limit moved it.
    """
    strides = nominal_strides(command, shape, yaw, side)
    wanted = xi - dcm_offset(strides, shape.omega, shape.duration)
    return clip_foothold(wanted, stance, yaw, side, shape)
