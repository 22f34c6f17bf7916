"""Compiled motion of the contact line of a swing foot, ``[x, y, z, pitch, yaw]``."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.polynomial_kernels import bump, quintic

Array = NDArray[np.float64]

SIZE = 5
Z, PITCH, YAW = 2, 3, 4
_SHORTEST = 1e-9  # [s] a motion that is shorter has arrived


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
def next_reference(reference: Array, target: Array, remaining: float, step: float) -> Array:
    """Return the motion without the bump at one time `step` [s] later, shape (3, 5).

    Args:
        reference: position, velocity, acceleration now, shape (3, 5).
        target: where it comes to rest, shape (5,).
        remaining: when it does, from now [s].
        step: [s].
    """
    return base_motion(reference, target, remaining, np.array([step])).reshape(3, SIZE)


@compiled
def add_bump(motion: Array, height: float, duration: float, t: Array) -> None:
    """Lift a motion without the bump, in place.

    Args:
        motion: position, velocity, acceleration, shape (3, n, 5).
        height: of the bump [m].
        duration: of the swing [s], positive.
        t: times since lift-off [s], shape (n,).
    """
    motion[:, :, Z] += bump(height, duration, t)


@compiled
def line_turn(motion: Array) -> Array:
    """Return direction, angular velocity and angular acceleration of a contact line.

    The line has no roll of its own, so the angular velocity is the one of
    ``rot_z(yaw) rot_y(pitch)``.

    Args:
        motion: [x, y, z, pitch, yaw], its rate and second derivative, shape (3, n, 5).

    Returns:
        Unit vectors, [rad/s] and [rad/s^2] in world, shape (3, n, 3).
    """
    n = motion.shape[1]
    turn = np.empty((3, n, 3))
    for i in range(n):
        pitch, yaw = motion[0, i, PITCH], motion[0, i, YAW]
        dp, dy = motion[1, i, PITCH], motion[1, i, YAW]
        ddp, ddy = motion[2, i, PITCH], motion[2, i, YAW]
        c, s, level = math.cos(yaw), math.sin(yaw), math.cos(pitch)
        turn[0, i, 0], turn[0, i, 1], turn[0, i, 2] = c * level, s * level, -math.sin(pitch)
        turn[1, i, 0], turn[1, i, 1], turn[1, i, 2] = -s * dp, c * dp, dy
        turn[2, i, 0] = -s * ddp - c * dp * dy
        turn[2, i, 1] = c * ddp - s * dp * dy
        turn[2, i, 2] = ddy
    return turn


@compiled
def contact_lines(motion: Array, R_WC: Array) -> tuple[Array, Array]:
    """Return the contact lines of two feet from their contact frames.

    Args:
        motion: of the lines: position of the middle comes first [m], shape (2, 3) or wider.
        R_WC: contact frames, x along the line, shape (2, 3, 3).

    Returns:
        (lines, rise): [x, y, z, yaw] of left and right [m, rad], shape (2, 4), and how much
        each rises per metre [-], shape (2,).
    """
    lines, rise = np.empty((2, 4)), np.empty(2)
    for side in range(2):
        R = R_WC[side]
        lines[side, :3] = motion[side, :3]
        lines[side, 3] = math.atan2(R[1, 0], R[0, 0])
        rise[side] = R[2, 0] / math.hypot(R[0, 0], R[1, 0])
    return lines, rise


@compiled
def climb_of_lines(motion: Array, R_WC: Array, half_length: float) -> Array:
    """Return how fast the end of each line climbs that climbs faster, heel or toe [m/s], (2,).

    A line that meets an edge with one end goes on turning about it: that end has stopped.

    Args:
        motion: of the lines: position, velocity of the middle and angular velocity come first
            [m, m/s, rad/s], shape (2, 9) or wider.
        R_WC: contact frames, x along the line, shape (2, 3, 3).
        half_length: X [m].
    """
    climb = np.empty(2)
    for side in range(2):
        R, w = R_WC[side], motion[side, 6:9]
        turning = w[0] * R[1, 0] - w[1] * R[0, 0]
        climb[side] = motion[side, 5] + half_length * abs(turning)
    return climb


@compiled
def present_line(reference: Array, height: float, duration: float, elapsed: float) -> Array:
    """Return what a swing foot should do now.

    Args:
        reference: position, velocity, acceleration without the bump, shape (3, 5).
        height: of the bump [m].
        duration: of the swing [s], positive.
        elapsed: time since lift-off [s].

    Returns:
        Middle of the line, its velocity and acceleration [m, s]; its direction, angular
        velocity and angular acceleration [rad, s]: rows in world, shape (6, 3).
    """
    motion = reference.copy().reshape(3, 1, SIZE)
    add_bump(motion, height, duration, np.array([elapsed]))
    rows = np.empty((6, 3))
    rows[:3] = motion[:, 0, :3]
    rows[3:] = line_turn(motion)[:, 0]
    return rows
