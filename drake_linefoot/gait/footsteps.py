"""Footholds from the divergent component of motion, with the limits of reach and of crossing."""

import math
from typing import NamedTuple

import numpy as np

from drake_linefoot.gait.pendulum import dcm_offset
from drake_linefoot.gait.state import GaitConstants, GaitState
from drake_linefoot.math.compiled import compiled
from drake_linefoot.types import Array

SIDE_SIGN = (1.0, -1.0)  # left foot is at +y of the body, right foot at -y
_TURN = 2.0 * math.pi
_TICKS = 0.002  # [s] durations are multiples of it, so that phases end at a tick


class StepCommand(NamedTuple):
    """What steps are to be like, in the heading frame.

    Attributes:
        velocity: forward and left [m/s], shape (2,).
        turn_rate: counter-clockwise [rad/s].
        duration: T, from one switch of the CoP to the next [s].
    """

    velocity: Array
    turn_rate: float
    duration: float


@compiled
def whole_ticks(duration: float) -> float:
    """Return the nearest duration that ends at a tick [s]."""
    return _TICKS * round(duration / _TICKS)


@compiled
def swing_duration(s: GaitState, c: GaitConstants) -> float:
    """Return how long a single support of a walk lasts at the commanded velocity [s].

    At speed it is shortened so that a step is not longer than `step_length`: the leg that
    stays behind would come to the end of its ankle or of its knee.
    """
    speed, usual = abs(s.command.velocity[0]), c.single_support
    if speed * (usual + c.double_support) <= c.step_length:
        return float(usual)
    short = whole_ticks(c.step_length / speed - c.double_support)
    return max(short, min(c.single_support_min, usual))


@compiled
def swing_time(s: GaitState, c: GaitConstants) -> float:
    """Return how long the swings of the present gait last [s]; in a run they overlap."""
    if s.command.flight > 0.0:
        return float(c.run_step + s.command.flight)
    return swing_duration(s, c)


@compiled
def step_command(s: GaitState, c: GaitConstants) -> StepCommand:
    """Return what footholds are made for: the command with what was learned of the speed."""
    velocity = s.command.velocity * s.speed.scale + s.speed.offset
    both = -s.command.flight if s.command.flight > 0.0 else c.double_support
    duration = swing_time(s, c) + both
    return StepCommand(velocity, s.command.turn_rate, duration)


@compiled
def weight_shift(s: GaitState, c: GaitConstants) -> tuple[float, float]:
    """Return d, how long a double support lasts, and when in it the CoP may jump [s]."""
    if s.command.flight > 0.0:
        return -s.command.flight, 0.0
    if s.recovery.steps > 0.0:
        return c.double_support_min, c.switch_min
    return c.double_support, c.switch


@compiled
def settle_time(s: GaitState, c: GaitConstants) -> float:
    """Return how long before its touchdown all of a swing but the height has arrived [s].

    On uneven ground, which a foot may meet early, recovery steps take no less than others.
    """
    recovers = (
        s.recovery.steps > 0.0 or s.command.flight > 0.0
    ) and s.ground.unevenness <= c.unevenness_max
    return float(c.settle_time_min if recovers else c.settle_time)


@compiled
def heading_vector(yaw: float, forward: float, left: float) -> Array:
    """Return (forward, left) of a heading frame in world, shape (2,)."""
    cos, sin = math.cos(yaw), math.sin(yaw)
    return np.array((cos * forward - sin * left, sin * forward + cos * left))


@compiled
def seen_from_stance(side: int, vector: Array, yaw: float) -> Array:
    """Return the parts of a vector ahead and outward from the stance foot `side`, shape (2,)."""
    turned = heading_vector(-yaw, vector[0], vector[1])
    turned[1] *= SIDE_SIGN[1 - side]
    return turned


@compiled
def nominal_strides(command: StepCommand, c: GaitConstants, yaw: float, side: int) -> Array:
    """Return the strides of a steady walk, from the foot `side` on.

    The path turns with the command; foothold k stands half a width left or right of it.

    Args:
        command: held for all strides.
        c: constants.
        yaw: heading at the first foot [rad].
        side: 0 if the first foot is the left, 1 if the right.

    Returns:
        Displacements in world [m], shape (c.strides_ahead, 2).
    """
    turn = command.turn_rate * command.duration
    # Chord of the arc: the path between two footholds is shorter than v T when it bends.
    half = 0.5 * turn
    chord = command.duration * (math.sin(half) / half if half else 1.0)
    vx, vy = chord * command.velocity[0], chord * command.velocity[1]
    # A sideways walk brings the feet nearer every other step: stand wide enough for it.
    width = max(c.step_width, c.step_limits[1] + abs(vy))
    # Along the path in the middle of the stride, from side to side at the footholds.
    count = int(c.strides_ahead)
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
def clip_foothold(
    foothold: Array, centre: Array, yaw: float, side: int, limits: Array
) -> tuple[Array, bool]:
    """Move a foothold to the nearest one within a rectangle.

    Args:
        foothold: desired position [m], shape (2,).
        centre: stance foot, from where the limits count [m], shape (2,).
        yaw: heading at touchdown [rad].
        side: side of the swing foot, 0 left, 1 right; outward is to this side.
        limits: forward and backward, least and most outward [m], shape (3,).

    Returns:
        (foothold, moved): shape (2,), and whether it had to be moved.
    """
    cos, sin = math.cos(yaw), math.sin(yaw)
    dx, dy = foothold[0] - centre[0], foothold[1] - centre[1]
    forward, outward = cos * dx + sin * dy, SIDE_SIGN[side] * (cos * dy - sin * dx)
    f = min(max(forward, -limits[0]), limits[0])
    o = min(max(outward, limits[1]), limits[2])
    if f == forward and o == outward:
        return foothold, False
    return centre + heading_vector(yaw, f, SIDE_SIGN[side] * o), True


@compiled
def next_foothold(
    xi: Array, stance: Array, yaw: float, side: int, command: StepCommand, c: GaitConstants
) -> tuple[Array, bool]:
    """Return the foothold that the DCM at the switch of the CoP asks for.

    Args:
        xi: DCM predicted for the moment the weight comes onto the new foot [m], shape (2,).
        stance: the present stance foot [m], shape (2,).
        yaw: heading at touchdown [rad].
        side: side of the new foot.
        command: what is commanded.
        c: constants, limits among them.

    Returns:
        (foothold, moved): shape (2,), and whether a limit moved it.
    """
    strides = nominal_strides(command, c, yaw, side)
    desired = xi - dcm_offset(strides, c.omega, command.duration)
    return clip_foothold(desired, stance, yaw, side, c.step_limits[:])


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
