"""The swing foot: a motion of five coordinates, continuous with two derivatives.

The coordinates are ``[x, y, z, pitch, yaw]`` of the contact line: its middle in world and
its direction. Height is a quintic between the two ground heights plus a smooth bump; all
else is a quintic that starts at the present reference, so that a target that moves while
the foot is in the air bends the motion without a jump.
"""

import math
from typing import NamedTuple

import numpy as np

from drake_linefoot.gait.state import PITCH, SIZE, YAW, Z
from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.splines import bump, landing_bump, quintic
from drake_linefoot.types import Array

_SHORTEST = 1e-9  # [s] a motion that is shorter has arrived
_HEEL_TIME = 0.6  # [-] of a swing, in which a foot pitches on its toe
# Shares of a swing: up a step the foot goes forward from the first on, and is at its height at the
# second; down it begins to come down at the third, and is where it lands at the fourth.
_FORWARD_FROM, _UP_BY, _DOWN_FROM, _FORWARD_BY = 0.3, 0.6, 0.35, 0.6
_STOP = 0.5  # [-] of the way at the present speed, in which a foot stops that waits at its height
_IN_TIME = 0.25  # [-] at least, of what is left of a swing


class LineMotion(NamedTuple):
    """Motion of contact lines.

    Attributes:
        position: [x, y, z, pitch, yaw] [m, rad], shape (..., 5).
        velocity: its rate, shape (..., 5).
        acceleration: its second derivative, shape (..., 5).
    """

    position: Array
    velocity: Array
    acceleration: Array


class Swing(NamedTuple):
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
        heel: how far the foot pitches on its toe after lift-off [rad].
        raised: by how much the middle of the line goes up with it, so that the toe does not go
            down [m].
        step: how much it goes up a step of the ground, 1, or down one, -1; 0 on one plane.
    """

    start: float
    end: float
    now: float
    reference: Array
    target: Array
    height: float
    settle: float
    heel: float = 0.0
    raised: float = 0.0
    step: float = 0.0


@compiled
def base_motion(reference: Array, target: Array, remaining: float, t: Array) -> Array:
    """Return the motion without the bump.

    Args:
        reference: position, velocity, acceleration at time 0, shape (3, 5).
        target: where it comes to rest, shape (5,).
        remaining: when it does [s]; one that has arrived stays.
        t: times [s], shape (n,).

    Returns:
        Position, velocity and acceleration at the times, shape (3, n, 5).
    """
    if remaining > _SHORTEST:
        goal = np.zeros((3, SIZE))
        goal[0] = target
        return quintic(reference, goal, remaining, t)
    motion = np.zeros((3, len(t), SIZE))
    motion[0] = reference[0]
    return motion


@compiled
def windows(
    step: float, remaining: float, done: tuple[float, float], at_rest: bool
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return when a foot goes forward, and when up or down.

    Args:
        step: see `Swing`.
        remaining: until it has arrived [s].
        done: since it was lifted, and how long all of its swing takes [s].
        at_rest: whether it has not moved forward yet: then it may wait.

    Returns:
        (forward, upward): how long it waits, and when it has arrived [s].
    """
    elapsed, duration = done
    least, up, down = _IN_TIME * remaining, max(step, 0.0), max(-step, 0.0)
    begin, end = _FORWARD_FROM * up, 1.0 - (1.0 - _FORWARD_BY) * down
    forward = (
        max(begin * duration - elapsed, 0.0) if at_rest else 0.0,
        end * duration - elapsed,
    )
    begin, end = _DOWN_FROM * down, 1.0 - (1.0 - _UP_BY) * up
    upward = (max(begin * duration - elapsed, 0.0), end * duration - elapsed)
    return (
        (forward[0], min(max(forward[1], least), remaining)),
        (upward[0], min(max(upward[1], least), remaining)),
    )


@compiled
def stepped_motion(
    reference: Array,
    target: Array,
    remaining: float,
    step: float,
    done: tuple[float, float],
    t: Array,
) -> Array:
    """Return the motion without the bump, clear of the edge of a step, see `windows`.

    Args:
        reference: position, velocity, acceleration at time 0, shape (3, 5).
        target: where it comes to rest, shape (5,).
        remaining: when it does [s].
        step: see `Swing`.
        done: since it was lifted, and how long all of its swing takes [s].
        t: times [s], shape (n,).

    Returns:
        Position, velocity and acceleration at the times, shape (3, n, 5).
    """
    if step == 0.0 or remaining <= _SHORTEST:
        return base_motion(reference, target, remaining, t)
    level = reference[1, 0] == 0.0 and reference[1, 1] == 0.0
    forward, upward = windows(step, remaining, done, level)
    motion = base_motion(
        reference, target, forward[1] - forward[0], np.maximum(t - forward[0], 0.0)
    )
    waits, leaves = motion, reference
    if upward[0] > 0.0:
        leaves = np.zeros((3, SIZE))
        leaves[0] = reference[0] + _STOP * upward[0] * reference[1]
        waits = base_motion(reference, leaves[0], upward[0], t)
    rises = base_motion(leaves, target, upward[1] - upward[0], np.maximum(t - upward[0], 0.0))
    for i in range(len(t)):
        motion[:, i, Z] = waits[:, i, Z] if t[i] < upward[0] else rises[:, i, Z]
    return motion


@compiled
def swing_motion(swing: Swing, times: Array) -> Array:
    """Return the motion of a swing foot.

    Args:
        swing: the swing.
        times: between its `now` and its `end` [s], shape (n,).

    Returns:
        Position, velocity and acceleration at the times, shape (3, n, 5).
    """
    remaining = swing.end - swing.settle - swing.now
    done = swing.now - swing.start, swing.end - swing.start
    motion = stepped_motion(
        swing.reference, swing.target, remaining, swing.step, done, times - swing.now
    )
    heel, duration = np.array((swing.heel, swing.raised)), swing.end - swing.start
    lift, pitch = lifted(swing.height, heel, duration, times - swing.start)
    motion[:, :, Z] += lift
    if swing.heel != 0.0:
        motion[:, :, PITCH] += pitch
    return motion


@compiled
def lifted(height: float, heel: Array, duration: float, t: Array) -> tuple[Array, Array]:
    """Return what a swing adds to the motion from where a foot stood to where it lands.

    A foot that first pitches on its toe comes down faster: in a flight it stays near the ground
    for too long else, and its leg gets straight.

    Args:
        height: apex [m].
        heel: pitch and rise of it, see `Swing` [rad, m], shape (2,).
        duration: of the swing [s], positive.
        t: since lift-off [s], shape (n,).

    Returns:
        Height and pitch, with two derivatives each, shape (3, n).
    """
    if heel[0] == 0.0:
        return bump(height, duration, t), np.zeros((3, len(t)))
    turn = bump(1.0, _HEEL_TIME * duration, t)
    return landing_bump(height, duration, t) + heel[1] * turn, heel[0] * turn


@compiled
def line_turn(position: Array, velocity: Array, acceleration: Array) -> tuple[Array, Array, Array]:
    """Return direction, angular velocity and angular acceleration of a contact line.

    The line has no roll of its own, so the angular velocity is the one of
    ``rot_z(yaw) rot_y(pitch)``.

    Args:
        position: [x, y, z, pitch, yaw], shape (5,).
        velocity: its rate, shape (5,).
        acceleration: its second derivative, shape (5,).

    Returns:
        (d, w, alpha) in world: unit vector, [rad/s], [rad/s^2], shape (3,) each.
    """
    c, s = math.cos(position[YAW]), math.sin(position[YAW])
    level, down = math.cos(position[PITCH]), math.sin(position[PITCH])
    dp, dy, ddp, ddy = velocity[PITCH], velocity[YAW], acceleration[PITCH], acceleration[YAW]
    d = np.array((c * level, s * level, -down))
    w = np.array((-s * dp, c * dp, dy))
    return d, w, np.array((-s * ddp - c * dp * dy, c * ddp - s * dp * dy, ddy))


@compiled
def line_axes(pitch: Array, yaw: Array) -> Array:
    """Return the frames of contact lines, ``rot_z(yaw) rot_y(pitch)``.

    Args:
        pitch: [rad], shape (n,).
        yaw: [rad], shape (n,).

    Returns:
        Shape (n, 3, 3).
    """
    R = np.zeros((len(pitch), 3, 3))
    for i in range(len(pitch)):
        c, s, u, w = math.cos(yaw[i]), math.sin(yaw[i]), math.cos(pitch[i]), math.sin(pitch[i])
        R[i, 0, 0], R[i, 0, 1], R[i, 0, 2] = c * u, -s, c * w
        R[i, 1, 0], R[i, 1, 1], R[i, 1, 2] = s * u, c, s * w
        R[i, 2, 0], R[i, 2, 2] = -w, u
    return R


@compiled
def present_line(
    reference: Array, height: float, heel: Array, duration: float, elapsed: float
) -> Array:
    """Return what a swing foot should do now.

    Args:
        reference: position, velocity, acceleration without the bump, shape (3, 5).
        height: of the bump [m].
        heel: see `lifted` [rad, m], shape (2,).
        duration: of the swing [s], positive.
        elapsed: time since lift-off [s].

    Returns:
        Middle of the line, its velocity and acceleration [m, s]; its direction, angular
        velocity and angular acceleration [rad, s]: rows in world, shape (6, 3).
    """
    lift, turn = lifted(height, heel, duration, np.array((elapsed,)))
    rows, line = np.empty((6, 3)), reference.copy()
    rows[:3] = reference[:, :3]
    rows[:3, Z] += lift[:, 0]
    if heel[0] != 0.0:
        line[:, PITCH] += turn[:, 0]
    rows[3], rows[4], rows[5] = line_turn(line[0], line[1], line[2])
    return rows
