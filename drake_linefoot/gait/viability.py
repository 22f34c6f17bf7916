"""Which pushes a pendulum survives that steps as far, as wide and as soon as a robot can.

Seen from the stance foot, forward and outward to the side of the foot that swings, the DCM zeta
grows with ``exp(w t)`` until the next foot carries the weight. Steps save the pendulum if and only
if such do that are the quickest, but for the first: those may start from any offset within
`viable_offsets`, and from no other.
"""

import math
from typing import NamedTuple

import numpy as np

from drake_linefoot.gait.step_program import PEAK
from drake_linefoot.gait.step_times import TIME_STEP
from drake_linefoot.math.compiled import compiled
from drake_linefoot.types import Array


class StepBounds(NamedTuple):
    """What steps a pendulum may make.

    Attributes:
        omega: its natural frequency [1/s].
        duration: of the quickest step, from one switch of the CoP to the next [s].
        limits: largest distance ahead, least and largest width [m], shape (3,).
        offsets: of the DCM after the first step, from which steps save it: `viable_offsets` of any
            that are so long, so wide and so quick, or `offset_limits` of those of legs [m], (2, 2).
    """

    omega: float
    duration: float
    limits: Array
    offsets: Array


@compiled
def viable_offsets(duration: float, limits: Array, omega: float) -> Array:
    """Return the bounds of a DCM from which steps bring a pendulum to rest.

    Steps are as long, as wide or as narrow as any, the widths in turn, and as quick as any: ahead
    ``L / (E - 1)``, and towards the next foot between ``(E w_min - w_max) / (E^2 - 1)`` and
    ``(E w_max - w_min) / (E^2 - 1)``, with ``E = exp(w T)``.

    Args:
        duration: T of the quickest step, from one switch of the CoP to the next [s].
        limits: `step_limits` of the constants [m], shape (3,).
        omega: natural frequency [1/s].

    Returns:
        Least and most ahead of and towards the next foot from the CoP [m], rows, shape (2, 2).
    """
    E, length, narrow, wide = math.exp(omega * duration), limits[0], limits[1], limits[2]
    bounds = np.empty((2, 2))
    bounds[0, 1] = length / (E - 1.0)
    bounds[0, 0] = -bounds[0, 1]
    bounds[1, 0] = (E * narrow - wide) / (E * E - 1.0)
    bounds[1, 1] = (E * wide - narrow) / (E * E - 1.0)
    return bounds


def offset_limits(
    shortest: float, idle: float, limits: Array, acceleration: Array, omega: float
) -> Array:
    """Return the bounds of a DCM from which steps that the legs can make bring a pendulum to rest.

    They are the widest `viable_offsets` of any duration. In it a foot goes as far as its
    acceleration allows: twice the length of a step, or from the narrowest to the widest.

    Args:
        shortest: step, from one switch of the CoP to the next [s].
        idle: part of a step in which no foot moves ahead or to the side [s].
        limits: as of `viable_offsets` [m], shape (3,).
        acceleration: of a swing foot, forward and to the side [m/s^2].
        omega: natural frequency [1/s].

    Returns:
        As of `viable_offsets`, shape (2, 2).
    """
    bounds = []
    for duration in np.arange(shortest, shortest + 1.0, TIME_STEP):
        ahead, aside = acceleration[:2] * max(duration - idle, 0.0) ** 2 / PEAK
        reached = np.minimum(limits, [0.5 * ahead, limits[1], limits[1] + aside])
        bounds.append(viable_offsets(duration, reached, omega))
    return np.column_stack([np.min(bounds, axis=0)[:, 0], np.max(bounds, axis=0)[:, 1]])


def can_step_on(bounds: StepBounds) -> bool:
    """Return whether the narrowest step may be followed by another, or is too wide for that."""
    _, narrow, wide = bounds.limits
    return bool(math.exp(bounds.omega * bounds.duration) * narrow <= wide)


def is_viable(zeta: Array, soonest: float, bounds: StepBounds) -> bool:
    """Return whether any sequence of steps saves a pendulum.

    Args:
        zeta: DCM from the stance foot, forward and outward [m], shape (2,).
        soonest: when the weight can come onto the next foot [s]; it may come later.
        bounds: of the steps.

    Raises:
        ValueError: no step can be followed by another, see `can_step_on`.
    """
    length, narrow, wide = bounds.limits
    if not can_step_on(bounds):
        raise ValueError(f"steps of {bounds.duration:g} s cannot be {narrow:g} to {wide:g} m wide")
    ahead, aside = bounds.offsets
    # Within which zeta tau has to be for a foothold u that leaves |zeta tau - u| ahead, and
    # u - zeta tau aside, which is outward for the foot after it, within the bounds.
    low = np.array([-length - ahead[1], narrow - aside[1]])
    high = np.array([length + ahead[1], wide - aside[0]])
    latest = math.inf
    for z, least, most in zip(np.asarray(zeta, dtype=float), low, high, strict=True):
        if z != 0.0:
            latest = min(latest, (most if z > 0.0 else least) / z)
    return math.exp(bounds.omega * soonest) <= latest


def viable_impulse(zeta: Array, direction: Array, soonest: float, bounds: StepBounds) -> float:
    """Return the largest sudden change of the CoM's velocity that steps survive [m/s].

    Args:
        zeta: DCM before it, as of `is_viable`.
        direction: of the change, forward and outward, a unit vector, shape (2,).
        soonest: when the weight can come onto the next foot [s].
        bounds: of the steps.

    Returns:
        0 when the pendulum is lost without a push. An impulse is it times the mass.
    """
    low, high = 0.0, bounds.omega * 10.0 * float(bounds.limits.max())
    if not is_viable(zeta, soonest, bounds):
        return 0.0
    while high - low > 1e-6 * high:
        middle = 0.5 * (low + high)
        pushed = zeta + middle / bounds.omega * np.asarray(direction)
        low, high = (middle, high) if is_viable(pushed, soonest, bounds) else (low, middle)
    return low
