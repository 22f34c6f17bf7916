"""When which foot stands over a horizon, where, and how the other one gets there."""

import math

import numpy as np

from drake_linefoot.gait.patches import line_pitch
from drake_linefoot.gait.state import PITCH, SIZE, YAW
from drake_linefoot.gait.swing import LineMotion, Swing, swing_motion
from drake_linefoot.math.compiled import compiled, inlined
from drake_linefoot.parts import FOREVER
from drake_linefoot.signals import GaitHorizon
from drake_linefoot.types import Array

LEFT, RIGHT = 0, 1
_TIME_EPSILON = 1e-9  # [s]


@inlined
def phase_ends(horizon: GaitHorizon) -> Array:
    """Return when the phases end, all but the last [s]."""
    ends: Array = horizon.ends[: int(horizon.phases) - 1, 1] - _TIME_EPSILON
    return ends


@compiled
def phase_at(ends: Array, t: float) -> int:
    """Return which phase contains a time `t` [s], given when phases end, see `phase_ends`."""
    phase = 0
    while phase < len(ends) and ends[phase] <= t:
        phase += 1
    return phase


@inlined
def swing_of(horizon: GaitHorizon, phase: int, side: int) -> Swing:
    """Return the swing of a foot in a phase; where it stands it says nothing."""
    h, i = horizon, phase
    start, end, now = h.swing[i, side, 0], h.swing[i, side, 1], h.swing[i, side, 2]
    height, settle = h.swing[i, side, 3], h.swing[i, side, 4]
    heel, raised, step = h.swing[i, side, 5], h.swing[i, side, 6], h.swing[i, side, 7]
    target = h.target[i, side]
    return Swing(start, end, now, h.reference[i, side], target, height, settle, heel, raised, step)


def phases_until(horizon: GaitHorizon) -> Array:
    """Return the ends of all phases [s]."""
    ends: Array = horizon.ends[: int(horizon.phases), 1].copy()
    return ends


def knots(horizon: GaitHorizon, t: float, count: int, step: float) -> Array:
    """Return knot times at most `step` apart such that no phase ends between two.

    Args:
        horizon: of the gait.
        t: first knot [s].
        count: number of intervals, at least 1.
        step: longest interval [s], positive.

    Returns:
        Increasing times [s], shape (count + 1,).

    Raises:
        ValueError: `count` is below 1 or `step` is not positive.
    """
    return knots_in_phases(phases_until(horizon), t, count, step)


@compiled
def knots_in_phases(ends: Array, t: float, count: int, step: float) -> Array:
    """Return `knots`, given when all phases end [s]."""
    if count < 1 or not step > 0.0:
        raise ValueError("knots: their number and the step between them must be positive")
    times, known, number, phase = np.empty(count + 1), len(ends) - 1, 1, 0
    times[0] = t
    while number <= count:
        now = times[number - 1]
        while phase < known and ends[phase] - _TIME_EPSILON <= now:
            phase += 1
        end = ends[phase]
        if end >= FOREVER or end <= now:  # nothing changes any more, as far as it is known
            pieces, length = count, step
        else:
            pieces = max(1, math.ceil((end - now) / step - 1e-6))
            length = (end - now) / pieces
        for i in range(min(pieces, count + 1 - number)):
            times[number] = now + length * (i + 1)
            number += 1
    return times


@inlined
def contacts(horizon: GaitHorizon, times: Array) -> Array:
    """Return which feet stand at `times` [s], 0 or 1, shape (n, 2)."""
    ends, standing = phase_ends(horizon), np.empty((len(times), 2))
    for i in range(len(times)):
        phase = phase_at(ends, times[i])
        standing[i, 0], standing[i, 1] = horizon.contact[phase, 0], horizon.contact[phase, 1]
    return standing


@inlined
def slopes_at(horizon: GaitHorizon, times: Array) -> Array:
    """Return the slope under each foot, or where it lands, at `times` [s], shape (n, 2, 2)."""
    ends, slopes = phase_ends(horizon), np.empty((len(times), 2, 2))
    for i in range(len(times)):
        slopes[i] = horizon.slopes[phase_at(ends, times[i])]
    return slopes


@inlined
def feet_motion(horizon: GaitHorizon, times: Array) -> LineMotion:
    """Return the motion of both contact lines at increasing times.

    Args:
        horizon: of the gait.
        times: [s], shape (n,).

    Returns:
        Positions, velocities and accelerations, shape (2, n, 5) each.
    """
    h, ends, n = horizon, phase_ends(horizon), len(times)
    motion = np.zeros((3, 2, n, SIZE))
    first = 0
    while first < n:
        phase = phase_at(ends, times[first])
        end = first + 1
        while end < n and phase_at(ends, times[end]) == phase:
            end += 1
        for side in range(2):
            if h.contact[phase, side] == 0.0:
                swinging = swing_motion(swing_of(h, phase, side), times[first:end])
                for order in range(3):
                    for i in range(first, end):
                        for j in range(SIZE):
                            motion[order, side, i, j] = swinging[order, i - first, j]
                continue
            yaw, slope = h.feet[phase, side, 3], h.slopes[phase, side]
            for i in range(first, end):
                for j in range(3):
                    motion[0, side, i, j] = h.feet[phase, side, j]
                motion[0, side, i, PITCH], motion[0, side, i, YAW] = line_pitch(slope, yaw), yaw
        first = end
    return LineMotion(motion[0], motion[1], motion[2])
