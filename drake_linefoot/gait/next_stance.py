"""Which foot stands next: the one that has landed, unless only a step with it saves the robot.

Where a push has left a foot too near, with the DCM beyond it, the other one would have to cross
over. The foot rather swings once more, while the other goes on standing.
"""

import math

import numpy as np

from drake_linefoot.gait.crossing import OWN_SIDE
from drake_linefoot.gait.footholds import cop_reach, known_offset
from drake_linefoot.gait.footsteps import (
    SIDE_SIGN,
    foot_heading,
    next_foothold,
    seen_from_stance,
    settle_time,
    step_command,
    swing_duration,
    weight_shift,
)
from drake_linefoot.gait.known_ground import room_of, snapped
from drake_linefoot.gait.patches import seen_from, span
from drake_linefoot.gait.pendulum import dcm, propagate_dcm
from drake_linefoot.gait.recovery import is_insufficient
from drake_linefoot.gait.state import GaitConstants, GaitState
from drake_linefoot.gait.step_program import (
    Step,
    StepProblem,
    best_step,
    solve_step,
)
from drake_linefoot.gait.touchdown import LATEST, foot_acceleration
from drake_linefoot.math.compiled import compiled


@compiled
def coming_step(s: GaitState, side: int, wait: float, c: GaitConstants) -> StepProblem:
    """Return the swing in which `side` stands, see `step_problem`, before it begins.

    Args:
        s: state of the gait; both feet are on the ground, the weight is on `s.clock.side`.
        side: 0 left, 1 right.
        wait: until the other foot is lifted [s].
        c: constants.
    """
    command, swing = step_command(s, c), swing_duration(s, c)
    yaw = foot_heading(s.command.yaw, s.command.turn_rate, wait + swing, command.duration)
    stance, xi = (
        s.robot.feet[side][:2],
        dcm(s.robot.pendulum_com[:], s.robot.pendulum_velocity[:], c.omega),
    )
    _, switch = weight_shift(s, c)
    before = 0.0 if side == int(s.clock.side) else min(switch, wait)
    xi = propagate_dcm(xi, s.robot.feet[int(s.clock.side)][:2], c.omega, before)
    xi = propagate_dcm(xi, stance, c.omega, wait - before)
    landing = propagate_dcm(xi, stance, c.omega, swing + switch)
    place, _ = next_foothold(landing, stance, yaw, 1 - side, command, c)
    place, patch = snapped(s, place, yaw, c)
    offset = known_offset(s, command, place, yaw, 1 - side, c)
    seen = seen_from(room_of(s, patch, yaw, c), stance, yaw, SIDE_SIGN[1 - side])
    aside = span(seen, 1)
    foot = seen_from_stance(side, s.robot.feet[1 - side][:2] - stance, yaw)
    return StepProblem(
        seen_from_stance(side, xi - stance, yaw),
        seen_from_stance(
            side, s.robot.pendulum_com[:2] + wait * s.robot.com_velocity[:2] - stance, yaw
        ),
        seen_from_stance(side, s.robot.com_velocity[:2], yaw),
        foot,
        np.zeros(2),
        foot,
        seen_from_stance(side, offset, yaw),
        foot_acceleration(s, c),
        swing,
        swing,
        min(c.swing_time_min * math.sqrt(s.swing.height[1 - side] / c.swing_height), swing),
        swing,
        LATEST * swing,
        switch,
        settle_time(s, c),
        seen_from_stance(side, s.robot.lean[:], yaw),
        seen,
        np.array((aside[0], aside[1])),
        cop_reach(s, patch, c),
    )


@compiled
def own_side_step(x: StepProblem, c: GaitConstants) -> Step:
    """Return the best step that does not cross, at any time."""
    u = np.empty(2)
    cost, time, moved, lost = best_step(x, OWN_SIDE, x.latest, c, u)
    return Step(time, u, moved, cost, lost)


@compiled
def next_stance(s: GaitState, side: int, wait: float, c: GaitConstants) -> tuple[int, bool]:
    """Return on which foot to stand next, and whether that step is insufficient.

    Args:
        s: as of `coming_step`.
        side: the foot whose turn it is.
        wait: until the other one is lifted [s].
        c: constants.
    """
    x = coming_step(s, side, wait, c)
    step = own_side_step(x, c)
    if step.lost:
        y, step = coming_step(s, 1 - side, wait, c), solve_step(x, c)
        repeat = own_side_step(y, c)
        if not repeat.lost or (step.lost and repeat.cost < step.cost):
            return 1 - side, is_insufficient(y, repeat, c)
    return side, is_insufficient(x, step, c)
