"""Compiled: where the swing foot should land and when, for the CoM of this moment."""

from __future__ import annotations

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
from drake_linefoot.math.compiled import compiled

Array = NDArray[np.float64]


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
def timed_target(
    com: Array,
    com_velocity: Array,
    stance: Array,
    present_yaw: float,
    remaining: float,
    shortest: float,
    hurry: float,
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

    The DCM runs away exponentially, so a step that is taken sooner can be shorter.

    Args:
        com: as in `swing_target`, like all that is not said here.
        com_velocity: now [m/s], shape (3,).
        stance: [x, y, z, yaw] [m, rad], shape (4,).
        present_yaw: of the swing foot [rad].
        remaining: until the planned touchdown [s].
        shortest: until the earliest touchdown [s].
        hurry: by which the time is shortened, again and again [s]; 0: never.
        switch: of the CoP after touchdown [s].
        yaw: desired heading [rad].
        side: of the swing foot.
        velocity: that is commanded [m/s], shape (2,).
        scale: learned, shape (2,).
        offset: learned [m/s], shape (2,).
        turn_rate: that is commanded [rad/s].
        slope: of the ground, shape (2,).
        shape: constants and limits.

    Returns:
        (target, moved, remaining): shape (5,), whether a limit moves it all the same, and the
        time until touchdown [s].
    """
    while True:
        target, moved = swing_target(
            com, com_velocity, stance, present_yaw, remaining, switch, yaw, side,
            velocity, scale, offset, turn_rate, slope, shape,
        )  # fmt: skip
        if not moved or hurry <= 0.0 or remaining - hurry < shortest:
            return target, moved, remaining
        remaining -= hurry
