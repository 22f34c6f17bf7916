"""When which foot stands over a horizon, where, and how the other one gets there."""

import math
from itertools import pairwise

import numpy as np

from drake_linefoot.gait.ground import line_pitch
from drake_linefoot.gait.state import PITCH, SIZE, YAW
from drake_linefoot.gait.swing import LineMotion, Swing, swing_motion
from drake_linefoot.parts import FOREVER
from drake_linefoot.signals import GaitHorizon
from drake_linefoot.types import Array

LEFT, RIGHT = 0, 1
_TIME_EPSILON = 1e-9  # [s]


def phase_ends(horizon: GaitHorizon) -> Array:
    """Return when the phases end, all but the last [s]."""
    ends: Array = horizon.ends[: int(horizon.phases) - 1, 1] - _TIME_EPSILON
    return ends


def swing_of(horizon: GaitHorizon, phase: int) -> Swing | None:
    """Return the swing of a phase; None where both feet stand."""
    h, i = horizon, phase
    if h.contact[i].all():
        return None
    start, end, now, height, settle = h.swing[i].tolist()
    return Swing(start, end, now, h.reference[i], h.target[i], height, settle)


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
    if count < 1 or not step > 0.0:
        raise ValueError(f"horizon of {count} knots of {step} s: both must be positive")
    times, number, ends = [t], 0, phase_ends(horizon).tolist()
    last = float(horizon.ends[int(horizon.phases) - 1, 1])
    while len(times) <= count:
        now = times[-1]
        while number < len(ends) and ends[number] <= now:
            number += 1
        end = float(horizon.ends[number, 1]) if number < len(ends) else last
        if end >= FOREVER or end <= now:  # nothing changes any more, as far as it is known
            pieces, length = count, step
        else:
            pieces = max(1, math.ceil((end - now) / step - 1e-6))
            length = (end - now) / pieces
        times.extend(now + length * (i + 1) for i in range(pieces))
    return np.array(times[: count + 1])


def contacts(horizon: GaitHorizon, times: Array) -> Array:
    """Return which feet stand at `times` [s], 0 or 1, shape (n, 2)."""
    standing: Array = horizon.contact[phase_ends(horizon).searchsorted(times, side="right")]
    return standing


def feet_motion(horizon: GaitHorizon, times: Array) -> LineMotion:
    """Return the motion of both contact lines at increasing times.

    Args:
        horizon: of the gait.
        times: [s], shape (n,).

    Returns:
        Positions, velocities and accelerations, shape (2, n, 5) each.
    """
    motion = np.zeros((3, 2, len(times), SIZE))
    starts = [0, *times.searchsorted(phase_ends(horizon)).tolist(), len(times)]
    for i, (first, end) in enumerate(pairwise(starts)):
        rows, swing, feet = slice(first, end), swing_of(horizon, i), horizon.feet[i]
        for side in (LEFT, RIGHT) if first < end else ():
            if swing is not None and not horizon.contact[i, side]:
                motion[:, side, rows] = swing_motion(swing, times[rows])
            else:
                motion[0, side, rows, :3] = feet[side, :3]
                motion[0, side, rows, YAW] = feet[side, 3]
                motion[0, side, rows, PITCH] = line_pitch(horizon.slope, feet[side, 3])
    return LineMotion(*motion)
