"""What people call the contacts of a state of the gait, and the swing of its foot in the air."""

from typing import NamedTuple

import numpy as np

from drake_linefoot.gait.gait_planner import present_targets
from drake_linefoot.gait.state import CONSTANTS, ENDLESS
from drake_linefoot.lab.simulation.channels import mode
from drake_linefoot.layout import Layout
from drake_linefoot.parts import FOREVER
from drake_linefoot.signals import GaitTargets
from drake_linefoot.statuses import Mode

TARGETS = Layout(GaitTargets, {})


class SwingOf(NamedTuple):
    """Motion and target of the foot that swings, or did last: views of the state."""

    reference: np.ndarray
    target: np.ndarray


def targets_of(state):
    """What holds now in a state of the gait."""
    return TARGETS.open(present_targets(np.array([state]), np.zeros(1, CONSTANTS)))


def named(targets):
    """The name of what holds now."""
    return Mode(int(mode(np.frombuffer(TARGETS.vector(targets), TARGETS.dtype))[0]))


def mode_of(state):
    """The name of what the feet do in a state, as `named` has it, in less time."""
    clock, standing = state.clock, sum(contact_of(state))
    if standing < 2:
        return (Mode.FLIGHT, Mode.SWING)[standing]
    if clock.queued == 0.0:
        return Mode.STAND
    return Mode.SHIFT if clock.touchdown.max() > clock.time else Mode.DOUBLE


def contact_of(state):
    """Whether the left and the right foot stand."""
    (a, b), (c, d) = state.clock.touchdown.tolist(), state.clock.lift_off.tolist()
    return a < c, b < d


def swing_of(state):
    """The swing of the foot on which the weight is not."""
    foot = 1 - int(state.clock.side)
    return SwingOf(state.swing.reference[foot], state.swing.target[foot])


def set_swing(state, start, end):
    """Let the foot on which the weight is not swing from `start` to `end` [s], in a walk."""
    clock, side = state.clock, int(state.clock.side)
    clock.touchdown[side], clock.lift_off[side], clock.queued = -1.0, FOREVER, ENDLESS
    clock.lift_off[1 - side], clock.touchdown[1 - side] = start, end
    clock.planned_touchdown[1 - side] = end


def phase_start(state):
    """When the last foot was lifted, or landed [s]."""
    clock, foot = state.clock, 1 - int(state.clock.side)
    return clock.touchdown.max() if contact_of(state)[foot] else clock.lift_off[foot]


def phase_end(state):
    """When the next foot is lifted, or lands [s]."""
    clock, side = state.clock, int(state.clock.side)
    if mode_of(state) == Mode.SHIFT:
        return clock.touchdown[side]
    times = clock.lift_off if contact_of(state)[1 - side] else clock.touchdown
    return times[1 - side]


def repeats_swing(state):
    """Whether the foot that has landed is the next to swing, in double support."""
    clock, side = state.clock, int(state.clock.side)
    return mode_of(state) == Mode.DOUBLE and clock.touchdown[side] < clock.touchdown[1 - side]


def in_final_step(state):
    """Whether a foot swings and no step is to follow."""
    return mode_of(state) == Mode.SWING and state.clock.queued == 0.0


def planned_touchdown(state):
    """When the foot that swings was to land before it was late [s]."""
    return state.clock.planned_touchdown[1 - int(state.clock.side)]
