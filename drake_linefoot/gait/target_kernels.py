"""Compiled: where the swing foot should land and when, for the CoM of this moment."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.gait.footstep_kernels import (
    StepShape,
    foot_heading,
    learned_command,
    nearest_turn,
    next_foothold,
    within_reach,
)
from drake_linefoot.gait.ground_kernels import height_on, line_pitch
from drake_linefoot.gait.pendulum_kernels import dcm, propagate_com, propagate_dcm
from drake_linefoot.gait.swing_kernels import YAW, base_motion
from drake_linefoot.math.compiled import compiled

Array = NDArray[np.float64]

_MOMENTS = np.array([0.0, 0.21, 0.5, 0.79, 1.0])  # [-] of a motion, where it may be fastest


@compiled
def swing_target(
    com: Array,
    com_velocity: Array,
    stance: Array,
    present_yaw: float,
    remaining: float,
    switch: float,
    yaw: float,
    side: int,
    velocity: Array,
    scale: Array,
    offset: Array,
    turn_rate: float,
    slope: Array,
    shape: StepShape,
) -> tuple[Array, bool]:
    """Return where the swing foot should land, for the CoM of this moment.

    Args:
        com: now [m], shape (3,).
        com_velocity: now [m/s], shape (3,).
        stance: the stance foot, where the CoP stays, [x, y, z, yaw] [m, rad], shape (4,).
        present_yaw: of the swing foot [rad], which takes the short way.
        remaining: until touchdown [s].
        switch: when the weight comes onto the foot, after its touchdown [s].
        yaw: desired heading now [rad].
        side: of the swing foot.
        velocity: that is commanded, as in `learned_command`, shape (2,).
        scale: learned, shape (2,).
        offset: learned [m/s], shape (2,).
        turn_rate: that is commanded [rad/s].
        slope: of the ground, rise per metre along x and y of the world, shape (2,).
        shape: constants and limits.

    Returns:
        (target, moved): [x, y, z, pitch, yaw], shape (5,), and whether a limit moved it.
    """
    command = learned_command(velocity, scale, offset, turn_rate)
    heading = foot_heading(yaw, turn_rate, remaining, shape.duration)
    xi = dcm(com, com_velocity, shape.omega)
    xi = propagate_dcm(xi, stance[:2], shape.omega, remaining + switch)
    place, moved = next_foothold(xi, stance[:2], heading, side, command, shape)
    landing = propagate_com(com, com_velocity, stance[:2], shape.omega, remaining)
    place, far = within_reach(place, landing, heading, side, shape)
    yaw = nearest_turn(heading, present_yaw)
    height, pitch = height_on(slope, stance, place), line_pitch(slope, yaw)
    return np.array([place[0], place[1], height, pitch, yaw]), moved or far


@compiled
def peak_acceleration(reference: Array, target: Array, duration: float) -> float:
    """Return the largest horizontal acceleration on the way to a target, of five moments [m/s^2].

    Args:
        reference: position, velocity, acceleration now, shape (3, 5).
        target: where the motion comes to rest, shape (5,).
        duration: of the motion [s].
    """
    motion = base_motion(reference, target, duration, duration * _MOMENTS)
    peak = 0.0
    for i in range(len(_MOMENTS)):
        peak = max(peak, math.hypot(motion[2, i, 0], motion[2, i, 1]))
    return peak


@compiled
def timed_target(
    com: Array,
    com_velocity: Array,
    stance: Array,
    reference: Array,
    remaining: float,
    shortest: float,
    decrement: float,
    settle: float,
    acceleration_max: float,
    switch: float,
    yaw: float,
    side: int,
    velocity: Array,
    scale: Array,
    offset: Array,
    turn_rate: float,
    slope: Array,
    shape: StepShape,
) -> tuple[Array, bool, float]:
    """Return where the swing foot should land, and when: sooner while that is out of reach.

    Args:
        com: as in `swing_target`, like all that is not said here, shape (3,).
        com_velocity: [m/s], shape (3,).
        stance: [m, rad], shape (4,).
        reference: of the swing foot now, without the bump, shape (3, 5).
        remaining: until the planned touchdown [s].
        shortest: until the earliest touchdown [s].
        decrement: by which the time is shortened, again and again [s]; 0: never.
        settle: before touchdown the foot is above its foothold [s].
        acceleration_max: along the ground, of a foot whose time is shortened [m/s^2].
        switch: [s].
        yaw: desired [rad].
        side: of the swing foot.
        velocity: [m/s], shape (2,).
        scale: learned, shape (2,).
        offset: learned [m/s], shape (2,).
        turn_rate: [rad/s].
        slope: shape (2,).
        shape: constants and limits.

    Returns:
        (target, moved, remaining): shape (5,), whether a limit moves it, time until touchdown [s].
    """
    target, moved = swing_target(
        com, com_velocity, stance, reference[0, YAW], remaining, switch, yaw, side,
        velocity, scale, offset, turn_rate, slope, shape,
    )  # fmt: skip
    while moved and decrement > 0.0 and remaining - decrement >= shortest:
        sooner = remaining - decrement
        nearer, far = swing_target(
            com, com_velocity, stance, reference[0, YAW], sooner, switch, yaw, side,
            velocity, scale, offset, turn_rate, slope, shape,
        )  # fmt: skip
        if peak_acceleration(reference, nearer, sooner - settle) > acceleration_max:
            break
        target, moved, remaining = nearer, far, sooner
    return target, moved, remaining
