"""Whether a foot passes the stance foot on its way without meeting it."""

import math

from drake_linefoot.gait.state import GaitConstants
from drake_linefoot.math.compiled import compiled
from drake_linefoot.types import Array

OWN_SIDE, AHEAD, BEHIND = 0.0, 1.0, -1.0  # where a foot crosses the line of the stance foot


@compiled
def passing_bound(foot: Array, outward: float, where: float, c: GaitConstants) -> float:
    """Return how far ahead a foot has to land that passes the stance foot on its way.

    Both coordinates of the foot follow the same law of time, so its way is straight. Nearer to the
    stance foot than `crossing_gap` sideways it has to be ahead of it or behind it, the length of a
    foot and that gap away.

    Args:
        foot: where it is, forward and outward [m], shape (2,).
        outward: where it lands [m].
        where: `AHEAD` or `BEHIND`.
        c: constants of the gait.

    Returns:
        Least distance in that direction [m]; minus infinity where there is none.
    """
    gap = c.crossing_gap
    clear, at = 2.0 * c.half_length + gap, where * foot[0]
    if foot[1] >= gap and outward >= gap:
        return -math.inf
    if foot[1] < gap and outward < gap:
        return clear
    if foot[1] < gap and at < clear:  # beside it already, and on its way out
        return -math.inf
    # So near it comes, or is no longer, at this share of its way.
    share = max((foot[1] - gap) / (foot[1] - outward), 1e-3)
    bound = at + (clear - at) / share
    return max(bound, clear) if outward < gap else bound


@compiled
def is_beside(u: Array, c: GaitConstants) -> bool:
    """Return whether a foot at u, forward and outward [m], is too near beside the stance foot."""
    return bool(u[1] < c.crossing_gap and abs(u[0]) < 2.0 * c.half_length + c.crossing_gap)
