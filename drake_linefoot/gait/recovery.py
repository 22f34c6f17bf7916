"""What follows steps that come short: hurried ones, and a foot that swings once more."""

import math

from drake_linefoot.gait.state import GaitConstants, GaitState
from drake_linefoot.gait.step_program import Step, StepProblem
from drake_linefoot.math.compiled import compiled


@compiled
def comes_short(x: StepProblem, step: Step, c: GaitConstants) -> bool:
    """Return whether a foothold is `short_step` from where its offset would be nominal.

    Ahead of it, behind it or aside.
    """
    tau, away = math.exp(c.omega * (step.time + x.switch)), 0.0
    for i in range(2):
        away = max(away, abs(x.dcm[i] * tau - x.offset[i] - step.foothold[i]))
    return away >= c.short_step


@compiled
def note_step(s: GaitState, short: bool, moved: bool, c: GaitConstants) -> None:
    """Note a foothold that was chosen: whether it comes short, and whether a limit moved it."""
    if short:
        s.recovery.hurried = c.hurried_steps
    s.recovery.moved_footholds += moved


@compiled
def note_stance(s: GaitState, short: bool, c: GaitConstants) -> None:
    """Note a touchdown: steps are hurried for some more if the coming one comes short."""
    s.recovery.hurried = c.hurried_steps if short else max(s.recovery.hurried - 1.0, 0.0)


@compiled
def forget_hurry(s: GaitState) -> None:
    """Take one's time from now on."""
    s.recovery.hurried = 0
