"""Which pushes a pendulum survives that steps as far, as wide and as soon as a robot can.

Seen from the stance foot, forward and outward to the side of the foot that swings, the DCM zeta
grows with ``exp(w t)`` until the next foot carries the weight. Steps save the pendulum if and only
if such do that are the quickest, but for the first: those may start from any offset within
`viable_offsets`, and from no other.
"""

import math
from typing import NamedTuple

import numpy as np

from drake_linefoot.gait.step_program import viable_offsets
from drake_linefoot.types import Array


class StepBounds(NamedTuple):
    """What steps a pendulum may make.

    Attributes:
        omega: its natural frequency [1/s].
        duration: of the quickest step, from one switch of the CoP to the next [s].
        limits: largest distance ahead, least and largest width [m], shape (3,).
    """

    omega: float
    duration: float
    limits: Array


def is_viable(zeta: Array, soonest: float, bounds: StepBounds) -> bool:
    """Return whether any sequence of steps saves a pendulum.

    Args:
        zeta: DCM from the stance foot, forward and outward [m], shape (2,).
        soonest: when the weight can come onto the next foot [s]; it may come later.
        bounds: of the steps.

    Raises:
        ValueError: the narrowest step is too wide for the quickest one to be followed by another.
    """
    length, narrow, wide = bounds.limits
    growth = math.exp(bounds.omega * bounds.duration)
    if growth * narrow > wide:
        raise ValueError(f"steps of {bounds.duration:g} s cannot be {narrow:g} to {wide:g} m wide")
    ahead, aside = viable_offsets(bounds.duration, bounds.limits, bounds.omega)
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
