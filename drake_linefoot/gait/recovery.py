"""What follows an insufficient step: recovery steps."""

import math

from drake_linefoot.gait.state import GaitConstants, GaitState
from drake_linefoot.gait.step_program import Step, StepProblem
from drake_linefoot.math.compiled import compiled


@compiled
def is_insufficient(x: StepProblem, step: Step, c: GaitConstants) -> bool:
    """Return whether a foothold is `short_step` from where its offset would be nominal.

    Ahead of it, behind it or aside; what the centre of pressure within the foot brings is not
    missing.
    """
    tau, away = math.exp(c.omega * (step.time + x.switch)), 0.0
    for i in range(2):
        given = x.pressure * (tau - 1.0) if i == 0 else 0.0
        away = max(away, abs(x.dcm[i] * tau - x.offset[i] - step.foothold[i]) - given)
    return away >= c.short_step


@compiled
def note_step(s: GaitState, insufficient: bool, moved: bool, c: GaitConstants) -> None:
    """Note a foothold that was chosen: whether it is insufficient, and whether a limit moved it."""
    if insufficient:
        s.recovery.steps = c.recovery_steps
    s.recovery.moved_footholds += moved


@compiled
def note_stance(s: GaitState, insufficient: bool, c: GaitConstants) -> None:
    """Note a touchdown: some more recovery steps follow if the coming one is insufficient."""
    s.recovery.steps = c.recovery_steps if insufficient else max(s.recovery.steps - 1.0, 0.0)


@compiled
def end_recovery(s: GaitState) -> None:
    """Take one's time from now on."""
    s.recovery.steps = 0
