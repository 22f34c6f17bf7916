"""Strides ahead on the ground that is known: each to where there is room for a foot."""

import numpy as np

from drake_linefoot.gait.footsteps import (
    StepCommand,
    clip_foothold,
    heading_vector,
    next_foothold,
    nominal_strides,
)
from drake_linefoot.gait.known_ground import is_felt, snapped
from drake_linefoot.gait.pendulum import balancing_cop, dcm_offset
from drake_linefoot.gait.state import GaitConstants, GaitState
from drake_linefoot.math.compiled import compiled
from drake_linefoot.types import Array

_FORESEEN = 4  # strides; what those behind are moved by changes nothing that matters


@compiled
def known_offset(
    s: GaitState, command: StepCommand, first: Array, yaw: float, side: int, c: GaitConstants
) -> Array:
    """Return the offset of the DCM from a foot for strides that end where there is ground.

    Args:
        s: state of the gait.
        command: what is commanded.
        first: place of the foot [m], shape (2,).
        yaw: its heading [rad].
        side: 0 if it is the left, 1 if the right.
        c: constants.

    Returns:
        [m], shape (2,).
    """
    strides = nominal_strides(command, c, yaw, side)
    if not is_felt(s, 0):
        turn, place, moved = command.turn_rate * command.duration, first[:2].copy(), np.zeros(2)
        for j in range(min(_FORESEEN, len(strides))):
            place += strides[j]
            there, _ = snapped(s, place, yaw + turn * (j + 1), c)
            away = there - place
            strides[j] += away - moved
            moved = away
    return dcm_offset(strides, c.omega, command.duration)


@compiled
def known_foothold(
    s: GaitState,
    xi: Array,
    stance: Array,
    yaw: float,
    side: int,
    command: StepCommand,
    c: GaitConstants,
) -> tuple[Array, int, Array]:
    """Return the foothold that the DCM at the switch of the CoP asks for, where there is ground.

    Args:
        s: state of the gait.
        xi: DCM predicted for the moment the weight comes onto the new foot [m], shape (2,).
        stance: the present stance foot [m], shape (2,).
        yaw: heading at touchdown [rad].
        side: side of the new foot.
        command: what is commanded.
        c: constants.

    Returns:
        (foothold, patch, aim): shape (2,), the patch of ground, and the DCM that is wanted then
        [m], shape (2,).
    """
    place, _ = next_foothold(xi, stance, yaw, side, command, c)
    if is_felt(s, 0):
        return place, 0, xi
    offset = known_offset(s, command, snapped(s, place, yaw, c)[0], yaw, side, c)
    place, _ = clip_foothold(xi - offset, stance, yaw, side, c.step_limits[:])
    place, patch = snapped(s, place, yaw, c)
    return place, patch, place + offset


@compiled
def cop_reach(s: GaitState, patch: int, c: GaitConstants) -> float:
    """Return how far the centre of pressure moves in a foot before one lands on a patch [m].

    Nowhere on felt ground, where feet can land as the DCM asks.
    """
    return 0.0 if is_felt(s, patch) else float(c.cop_reach)


@compiled
def cop_towards(
    xi: Array, aim: Array, foot: Array, omega: float, duration: float, reach: float
) -> Array:
    """Return the centre of pressure within a foot that takes the DCM nearest to where it is wanted.

    Args:
        xi: DCM now [m], shape (2,).
        aim: where it is to be after `duration` [m], shape (2,).
        foot: [x, y, z, yaw].
        omega: natural frequency [1/s].
        duration: [s].
        reach: from the middle of the foot, along it, at most [m]; 0 gives the middle.

    Returns:
        [m], shape (2,).
    """
    middle = foot[:2].copy()
    if reach <= 0.0 or duration <= 1e-3:
        return middle
    away = balancing_cop(xi, aim, omega, duration) - middle
    ahead = heading_vector(-foot[3], away[0], away[1])[0]
    return middle + heading_vector(foot[3], min(max(ahead, -reach), reach), 0.0)
