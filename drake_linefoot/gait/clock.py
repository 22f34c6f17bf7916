"""The clock of the gait: its phases, and when each is over."""

from drake_linefoot.gait.state import GaitState
from drake_linefoot.math.compiled import compiled


@compiled
def start_phase(s: GaitState, mode: float, side: int, duration: float) -> None:
    """Start a phase in which the weight is on `side`, or goes there, for a time [s]."""
    s.clock.mode, s.clock.side, s.clock.closing = mode, side, 0
    s.clock.phase_start = s.clock.time
    s.clock.phase_end = s.clock.due = s.clock.time + duration


@compiled
def advance_clock(s: GaitState, time: float) -> None:
    """Go on to `time` [s]."""
    s.clock.time = time


@compiled
def land_at(s: GaitState, end: float) -> None:
    """Plan the touchdown of the present swing for `end` [s]."""
    s.clock.phase_end = s.clock.due = end


@compiled
def go_on_until(s: GaitState, end: float) -> None:
    """Let a swing whose touchdown is late go on until `end` [s]."""
    s.clock.phase_end = end


@compiled
def close_step(s: GaitState, closes: bool) -> None:
    """Say whether the present swing puts its foot beside the other one, to stand."""
    s.clock.closing = closes


@compiled
def count_step(s: GaitState) -> None:
    """Count a step that is done."""
    s.clock.steps += 1
