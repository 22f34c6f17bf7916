"""Compiled: footholds from the divergent component of motion, with reach and crossing limits."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.gait.pendulum_kernels import dcm_offset
from drake_linefoot.math.compiled import compiled

Array = NDArray[np.float64]

SIDE_SIGN = (1.0, -1.0)  # left foot is at +y of the body, right foot at -y
_TURN = 2.0 * math.pi
_STRIDES_AHEAD = 6  # exp(-6 w T) is below 0.5 % for w T = 0.9


class StepCommand(NamedTuple):
    """What the gait is asked to do, in the heading frame.

    Attributes:
        velocity: forward and left [m/s], shape (2,).
        turn_rate: counter-clockwise [rad/s].
    """

    velocity: Array
    turn_rate: float


class StepShape(NamedTuple):
    """The constants of a step.

    Attributes:
        duration: T, from one switch of the CoP to the next [s].
        width: lateral distance between the feet when standing [m].
        omega: natural frequency of the pendulum [1/s].
        length_max: largest forward distance between the feet [m].
        width_min, width_max: smallest and largest lateral distance [m].
        reach_forward: of a landing foot from the CoM, ahead or behind [m].
        reach_outward: of a landing foot from the CoM, to its own side [m].
    """

    duration: float
    width: float
    omega: float
    length_max: float
    width_min: float
    width_max: float
    reach_forward: float
    reach_outward: float


@compiled
def heading_vector(yaw: float, forward: float, left: float) -> Array:
    """Return (forward, left) of a heading frame in world, shape (2,)."""
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([c * forward - s * left, s * forward + c * left])


@compiled
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
    vx, vy = chord * command.velocity[0], chord * command.velocity[1]
    # A sideways walk brings the feet nearer every other step: stand wide enough for it.
    width = max(shape.width, shape.width_min + abs(vy))
    # Along the path in the middle of the stride, from side to side at the footholds.
    strides = np.empty((count, 2))
    aside = 0.5 * width * SIDE_SIGN[side]
    before = heading_vector(yaw, 0.0, aside)
    for k in range(count):
        aside = -aside
        after = heading_vector(yaw + turn * (k + 1), 0.0, aside)
        strides[k] = heading_vector(yaw + turn * k + half, vx, vy) + after - before
        before = after
    return strides


@compiled
def clip_around(
    place: Array,
    centre: Array,
    yaw: float,
    side: int,
    forward_max: float,
    outward_min: float,
    outward_max: float,
) -> tuple[Array, bool]:
    """Move a place into a rectangle.

    Args:
        place: desired position [m], shape (2,).
        centre: what the limits are counted from [m], shape (2,).
        yaw: heading of the rectangle [rad].
        side: 0 left, 1 right; outward is to this side.
        forward_max: ahead and behind [m].
        outward_min: to the side [m].
        outward_max: to the side [m].

    Returns:
        (place, moved): shape (2,), and whether it had to be moved.
    """
    c, s = math.cos(yaw), math.sin(yaw)
    dx, dy = place[0] - centre[0], place[1] - centre[1]
    forward, outward = c * dx + s * dy, SIDE_SIGN[side] * (c * dy - s * dx)
    f = min(max(forward, -forward_max), forward_max)
    o = min(max(outward, outward_min), outward_max)
    if f == forward and o == outward:
        return place, False
    return centre + heading_vector(yaw, f, SIDE_SIGN[side] * o), True


@compiled
def clip_foothold(
    foothold: Array, stance: Array, yaw: float, side: int, shape: StepShape
) -> tuple[Array, bool]:
    """Move a foothold to the nearest one the leg can reach without crossing.

    Args:
        foothold: desired position [m], shape (2,).
        stance: position of the stance foot [m], shape (2,).
        yaw: heading at touchdown [rad].
        side: side of the swing foot, 0 left, 1 right.
        shape: limits.

    Returns:
        (foothold, moved): shape (2,), and whether it had to be moved.
    """
    return clip_around(
        foothold, stance, yaw, side, shape.length_max, shape.width_min, shape.width_max
    )


@compiled
def within_reach(
    foothold: Array, com: Array, yaw: float, side: int, shape: StepShape
) -> tuple[Array, bool]:
    """Move a foothold to where the leg can reach it from the CoM.

    Args:
        foothold: desired position [m], shape (2,).
        com: at touchdown [m], shape (2,).
        yaw: heading at touchdown [rad].
        side: side of the swing foot, 0 left, 1 right.
        shape: limits.

    Returns:
        (foothold, moved): shape (2,), and whether it had to be moved.
    """
    return clip_around(
        foothold, com, yaw, side, shape.reach_forward, -math.inf, shape.reach_outward
    )


@compiled
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
    desired = xi - dcm_offset(strides, shape.omega, shape.duration)
    return clip_foothold(desired, stance, yaw, side, shape)


@compiled
def nearest_turn(yaw: float, present: float) -> float:
    """Return `yaw` shifted by whole turns to within half a turn of `present` [rad]."""
    return yaw - _TURN * round((yaw - present) / _TURN)


@compiled
def foot_heading(yaw: float, turn_rate: float, after: float, duration: float) -> float:
    """Return where a foot that lands `after` [s] from now points [rad].

    It is the heading half a step later, when the body passes over the foot; with the
    heading at touchdown the path would lag behind the torso in a turn.

    Args:
        yaw: desired heading now [rad].
        turn_rate: desired [rad/s].
        after: [s].
        duration: of a step [s].
    """
    return yaw + turn_rate * (after + 0.5 * duration)


@compiled
def learned_command(velocity: Array, scale: Array, offset: Array, turn_rate: float) -> StepCommand:
    """Return the command that footholds are made for.

    Args:
        velocity: that is asked for, forward and left [m/s], shape (2,).
        scale: learned from the speed that came of it [-], shape (2,).
        offset: likewise [m/s], shape (2,).
        turn_rate: that is asked for [rad/s].
    """
    return StepCommand(velocity * scale + offset, turn_rate)
