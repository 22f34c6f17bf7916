"""The times at which a step may land, and what each costs, in the step program."""

import math

from drake_linefoot.math.compiled import compiled

TIME_STEP = 0.002  # [s] between the times that are tried: phases end at a tick
_WEIGHT = 0.01
_SAME = 1e-6  # [-] of the step between two times


@compiled
def ticks(nominal: float, shortest: float, longest: float) -> tuple[int, int]:
    """Return the first and the last time between two bounds [s], in steps after the nominal one."""
    first = math.ceil((shortest - nominal) / TIME_STEP - _SAME)
    last = math.floor((longest - nominal) / TIME_STEP + _SAME)
    return first, last


@compiled
def time_cost(later: float, omega: float) -> float:
    """Return what a time costs that is so much `later` than the nominal one [s].

    Args:
        later: [s].
        omega: natural frequency [1/s].
    """
    return float(_WEIGHT * math.expm1(omega * later) ** 2)
