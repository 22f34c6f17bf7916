"""Which feet are in contact, and what that says of the walk: predicates of a state of the gait.

A foot is in contact from its touchdown to the next one's plus d, see `Clock`: with d > 0 it walks,
with d < 0 it flies, and where no step is queued contact has no end. Any number of feet may swing.
"""

from drake_linefoot.gait.state import GaitState
from drake_linefoot.math.compiled import compiled


@compiled
def in_contact(s: GaitState, foot: int) -> bool:
    """Return whether a foot stands: its touchdown was after it was lifted last."""
    return bool(s.clock.touchdown[foot] < s.clock.lift_off[foot])


@compiled
def in_double_support(s: GaitState) -> bool:
    """Return whether both feet stand."""
    return in_contact(s, 0) and in_contact(s, 1)


@compiled
def standing_still(s: GaitState) -> bool:
    """Return whether both feet stand and no step is queued."""
    return in_double_support(s) and s.clock.queued == 0.0


@compiled
def is_stepping(s: GaitState) -> bool:
    """Return whether the weight is on one foot, or on its way there.

    Not so of a robot that stands, or waits for the time at which its first step begins.
    """
    waits = s.clock.touchdown[int(s.clock.side)] > s.clock.time
    return not in_double_support(s) or (s.clock.queued > 0.0 and not waits)


@compiled
def in_final_step(s: GaitState) -> bool:
    """Return whether a foot swings and no step is to follow."""
    return not in_double_support(s) and s.clock.queued == 0.0
