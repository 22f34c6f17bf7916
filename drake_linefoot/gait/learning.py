"""What the gait learns at every touchdown: of its own speed, and of the ground."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.gait.footstep_kernels import heading_vector
from drake_linefoot.gait.ground_kernels import learn_slope
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.gait.state import GaitState

Array = NDArray[np.float64]

_SLOW = 0.1  # [m/s] commands below it teach an offset of the speed, above it a scale


def no_marks() -> Array:
    """Return marks of a walk that has not begun, shape (2, 3)."""
    return np.tile([-1.0, 0.0, 0.0], (2, 1))


def learn_speed(p: GaitParameters, state: GaitState, steady: bool) -> GaitState:
    """Compare the speed over the last two steps with the command, once a step.

    The pendulum leaves out the legs, so a walk that follows it is a little slower
    than commanded, in proportion; a turn in place goes round a little beside the feet.
    So an error goes to a scale at speed, and to an offset at rest. While the command
    changes nothing is learned.

    Args:
        p: how much is learned, and bounds.
        state: at touchdown.
        steady: whether the velocity has reached the command.
    """
    mark = np.array([state.time, state.com[0], state.com[1]])
    if not steady:
        return state.changed(marks=no_marks())
    before, scale, offset = state.marks[1], state.speed_scale, state.speed_offset
    if before[0] >= 0.0:
        travelled = (mark - before)[1:] / (mark[0] - before[0])
        middle = state.yaw - 0.5 * state.turn_rate * (mark[0] - before[0])
        v = state.velocity
        error = v - heading_vector(-middle, *travelled)
        learned = p.speed_learning * error / (v**2 + _SLOW**2)
        scale = np.clip(scale + learned * v, 1.0 / p.speed_scale_max, p.speed_scale_max)
        limit = p.speed_offset_max
        offset = np.clip(offset + learned * _SLOW**2, -limit, limit)
    return state.changed(
        speed_scale=scale, speed_offset=offset, marks=np.stack([mark, state.marks[0]])
    )


def learn_ground(p: GaitParameters, state: GaitState, rise: float) -> GaitState:
    """Compare the slope of the ground with how both feet stand, once a step.

    Args:
        p: how much is learned, and the bound.
        state: at touchdown; `feet` are where they stand.
        rise: of the stance line per metre [-].
    """
    if not p.slope_learning:
        return state
    slope = learn_slope(state.slope, state.feet, state.side, rise, p.slope_learning, p.slope_max)
    return state.changed(slope=slope)
