"""The clock of the gait: when which foot is in contact, as it was and as it is planned.

Each function is an event: a foot is lifted, or lands; or a plan that one will.
"""

from drake_linefoot.gait.contacts import in_contact
from drake_linefoot.gait.state import ENDLESS, GaitState
from drake_linefoot.math.compiled import compiled
from drake_linefoot.parts import FOREVER


@compiled
def advance_clock(s: GaitState, time: float) -> None:
    """Go on to `time` [s]."""
    s.clock.time = time


@compiled
def stand_still(s: GaitState) -> None:
    """Keep both feet where they stand, for ever."""
    s.clock.queued = 0.0
    for foot in range(2):
        s.clock.touchdown[foot] = min(s.clock.touchdown[foot], s.clock.time)
        s.clock.planned_touchdown[foot] = s.clock.touchdown[foot]
        s.clock.lift_off[foot] = FOREVER


@compiled
def load_foot(s: GaitState, stance: int, time: float, overlap: float) -> None:
    """Let the weight go onto a foot that stands, from `time` [s] on, as if it landed then.

    Args:
        s: state of the gait; both feet stand.
        stance: the foot.
        time: now, or later: of the first step.
        overlap: d of the other foot, which is lifted then [s].
    """
    s.clock.side, s.clock.queued, s.clock.overlap = stance, ENDLESS, overlap
    for foot in range(2):  # the weight may have been meant for the other one
        before = min(s.clock.touchdown[foot], s.clock.time)
        s.clock.touchdown[foot] = time if foot == stance else before
        s.clock.planned_touchdown[foot] = s.clock.touchdown[foot]
    s.clock.lift_off[stance], s.clock.lift_off[1 - stance] = FOREVER, time + overlap


@compiled
def land_foot(s: GaitState, foot: int, stance: int, overlap: float) -> None:
    """Stand on a foot that has landed, and plan when the next one is lifted.

    Args:
        s: state of the gait.
        foot: that has landed.
        stance: on which to stand next, it or the other.
        overlap: d of the other foot [s].
    """
    s.clock.side, s.clock.overlap = stance, overlap
    s.clock.touchdown[foot] = s.clock.planned_touchdown[foot] = s.clock.time
    if in_contact(s, 1 - foot):
        s.clock.lift_off[stance], s.clock.lift_off[1 - stance] = FOREVER, s.clock.time + overlap
    else:
        s.clock.lift_off[foot] = s.clock.touchdown[1 - foot] + overlap


@compiled
def lift_foot(s: GaitState, foot: int, duration: float) -> None:
    """Lift a foot, to land after a `duration` [s]."""
    s.clock.side, s.clock.lift_off[foot] = 1 - foot, s.clock.time
    plan_touchdown(s, foot, s.clock.time + duration)


@compiled
def plan_touchdown(s: GaitState, foot: int, end: float) -> None:
    """Plan the touchdown of a foot that swings for `end` [s]."""
    s.clock.planned_touchdown[foot] = end
    delay_touchdown(s, foot, end)


@compiled
def delay_touchdown(s: GaitState, foot: int, end: float) -> None:
    """Expect a late foot by `end` [s]; the other one stands until then plus d."""
    standing = in_contact(s, 1 - foot)
    s.clock.touchdown[foot] = end
    if standing:
        s.clock.lift_off[1 - foot] = end + s.clock.overlap if s.clock.queued > 0.0 else FOREVER


@compiled
def end_walk(s: GaitState, ends: bool) -> None:
    """Let no step follow the one in which a foot swings, if the walk `ends` with it."""
    if ends:
        s.clock.queued, s.clock.lift_off[int(s.clock.side)] = 0.0, FOREVER


@compiled
def count_step(s: GaitState) -> None:
    """Count a step that is done."""
    s.clock.steps += 1
