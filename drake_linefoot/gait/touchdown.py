"""Where a foot that swings should land and when, for the CoM of this moment."""

import math

import numpy as np

from drake_linefoot.gait.contacts import in_final_step
from drake_linefoot.gait.footholds import cop_reach, known_offset
from drake_linefoot.gait.footsteps import (
    SIDE_SIGN,
    foot_heading,
    heading_vector,
    nearest_turn,
    seen_from_stance,
    settle_time,
    step_command,
    swing_duration,
    weight_shift,
)
from drake_linefoot.gait.known_ground import (
    edges_at,
    height_at,
    is_felt,
    room_of,
    snapped,
)
from drake_linefoot.gait.patches import is_within, moved_inside, seen_from, span
from drake_linefoot.gait.pendulum import dcm
from drake_linefoot.gait.recovery import is_insufficient, note_step
from drake_linefoot.gait.state import YAW, GaitConstants, GaitState, Z
from drake_linefoot.gait.step_bound import may_cost_less
from drake_linefoot.gait.step_program import PEAK, Step, StepProblem, solve_step
from drake_linefoot.gait.swing import lifted
from drake_linefoot.gait.swing_foot import fit_swing, retime_step, set_aim, set_target
from drake_linefoot.math.compiled import compiled
from drake_linefoot.types import Array

LATEST = 1.3  # [-] of a swing: so long it may last where its foot would land too near
_CHOSEN = 0.5  # [-] of a swing, after which its patch of ground is chosen
_LOOK = 0.01  # [s] between two looks at other patches
_ANOTHER = 0.9  # [-] of the cost of a step onto a patch, below which another one is better
_TICK = 1e-6  # [s], less than a tick
_SAME = 1e-9  # [s] between two times that count as equal


@compiled
def place_beside(s: GaitState, foot: int, c: GaitConstants) -> Array:
    """Return the place of a foot beside the other one where a walk ends [m], shape (2,)."""
    aside = SIDE_SIGN[foot] * c.step_width
    return s.robot.feet[1 - foot][:2] + heading_vector(s.command.yaw, 0.0, aside)


@compiled
def ends_beside(s: GaitState, foot: int, c: GaitConstants) -> bool:
    """Return whether a foot, where it is to land, may be put beside the other to stand."""
    miss = s.swing.target[foot, :2] - place_beside(s, foot, c)
    still = (
        s.command.velocity[0] == 0.0 and s.command.velocity[1] == 0.0 and s.command.turn_rate == 0.0
    )
    return bool(still and math.hypot(miss[0], miss[1]) < c.final_step_tolerance)


@compiled
def planned_height(s: GaitState, foot: int) -> tuple[float, float]:
    """Return how high above the ground a foot should be now [m], and how fast it rises [m/s]."""
    reference = s.swing.reference[foot]
    start, end = s.clock.lift_off[foot], s.clock.touchdown[foot]
    elapsed = np.array((s.clock.time - start,))
    lift, _ = lifted(s.swing.height[foot], s.swing.heel[foot], end - start, elapsed)
    ground = height_at(s, int(s.terrain.under[foot]), 1 - foot, reference[0])
    return reference[0, Z] + lift[0, 0] - ground, reference[1, Z] + lift[1, 0]


@compiled
def soonest(s: GaitState, foot: int, c: GaitConstants) -> float:
    """Return how soon a foot may land: it must be lifted, and come down again [s]."""
    elapsed, above = s.clock.time - s.clock.lift_off[foot], max(planned_height(s, foot)[0], 0.0)
    down = math.sqrt(PEAK * above / c.swing_acceleration[2]) + settle_time(s, c)
    return max(down, c.swing_time_min * math.sqrt(s.swing.height[foot] / c.swing_height) - elapsed)


@compiled
def foot_acceleration(s: GaitState, c: GaitConstants) -> Array:
    """Return the bound of a swing foot's acceleration, forward and to the side [m/s^2], shape (2,).

    It never holds back a steady walk, whose foot swings as far as two steps take it.
    """
    command, left = step_command(s, c), swing_duration(s, c) - settle_time(s, c)
    steady = 2.0 * PEAK * command.duration / left**2 * np.abs(command.velocity)
    return np.maximum(c.swing_acceleration[:2], steady)


@compiled
def step_problem(s: GaitState, foot: int, yaw: float, patch: int, c: GaitConstants) -> StepProblem:
    """Return the swing of a foot as `solve_step` takes it.

    Args:
        s: state of the gait.
        foot: that swings, 0 left, 1 right.
        yaw: heading at touchdown [rad].
        patch: of ground that it is to land on.
        c: constants.
    """
    side, command, motion = 1 - foot, step_command(s, c), s.swing.reference[foot]
    stance, room = s.robot.feet[side][:2], room_of(s, patch, yaw, c)
    xi = dcm(s.robot.pendulum_com[:], s.robot.pendulum_velocity[:], c.omega)
    first, _ = moved_inside(room, s.swing.target[foot])
    offset = known_offset(s, command, first, yaw, 1 - side, c)
    seen = seen_from(room, stance, yaw, SIDE_SIGN[foot])
    aside = span(seen, 1)
    time, start, end = s.clock.time, s.clock.lift_off[foot], s.clock.touchdown[foot]
    planned, elapsed = end - time, time - start
    swing = swing_duration(s, c)
    nominal = swing - elapsed
    return StepProblem(
        seen_from_stance(side, xi - stance, yaw),
        seen_from_stance(side, s.robot.pendulum_com[:2] - stance, yaw),
        seen_from_stance(side, s.robot.com_velocity[:2], yaw),
        seen_from_stance(side, motion[0, :2] - stance, yaw),
        seen_from_stance(side, motion[1, :2], yaw),
        seen_from_stance(side, s.swing.target[foot, :2] - stance, yaw),
        seen_from_stance(side, offset, yaw),
        foot_acceleration(s, c),
        planned,
        nominal,
        min(soonest(s, foot, c), planned),
        max(nominal, planned),
        max(LATEST * swing - elapsed, planned),
        weight_shift(s, c)[1],
        settle_time(s, c),
        seen_from_stance(side, s.robot.lean[:], yaw),
        seen,
        np.array((aside[0], aside[1])),
        cop_reach(s, patch, c),
    )


@compiled
def solve_on_ground(
    s: GaitState, foot: int, yaw: float, c: GaitConstants
) -> tuple[Step, StepProblem, int]:
    """Return the best step onto any patch in reach, the swing it solves, and the patch.

    Others than the one it is on its way to are looked at every 10 ms.
    """
    patch = int(s.terrain.under[foot])
    x = step_problem(s, foot, yaw, patch, c)
    step = solve_step(x, c)
    stance, elapsed = s.robot.feet[1 - foot], s.clock.time - s.clock.lift_off[foot]
    late = elapsed > _CHOSEN * (s.clock.touchdown[foot] - s.clock.lift_off[foot])
    looks = abs(elapsed / _LOOK - round(elapsed / _LOOK)) * _LOOK < _TICK
    none_is_better = step.cost == 0.0 or (step.cost < math.inf and (late or not looks))
    if is_felt(s, patch) or none_is_better:
        return step, x, patch
    reach = math.hypot(c.step_limits[0], c.step_limits[2])
    for k in range(int(s.terrain.count)):
        if k == patch or not is_within(edges_at(s, k), stance, reach):
            continue
        if abs(height_at(s, k, 1 - foot, stance) - stance[Z]) > c.rise_max:
            continue
        y = step_problem(s, foot, yaw, k, c)
        if y.aside[0] > y.aside[1] or not may_cost_less(y, _ANOTHER * step.cost, c):
            continue
        other = solve_step(y, c)
        if other.cost < _ANOTHER * step.cost:
            step, x, patch = other, y, k
    return step, x, patch


@compiled
def update_foothold(s: GaitState, foot: int, c: GaitConstants) -> bool:
    """Choose where a foot that swings will land, and when, see `step_program`.

    Returns:
        Whether a limit moved the foothold.
    """
    planned, moved = s.clock.touchdown[foot] - s.clock.time, False
    stance, duration = s.robot.feet[1 - foot], step_command(s, c).duration
    heading = foot_heading(s.command.yaw, s.command.turn_rate, planned, duration)
    if in_final_step(s):
        place, patch = snapped(s, place_beside(s, foot, c), heading, c)
    else:
        step, x, patch = solve_on_ground(s, foot, heading, c)
        if step.cost == math.inf:  # no ground is in reach: it goes on to where it was going
            return True
        note_step(s, is_insufficient(x, step, c), step.moved, c)
        remaining, u, moved = step.time, step.foothold, step.moved
        aside = SIDE_SIGN[foot] * u[1]
        place = stance[:2] + heading_vector(heading, u[0], aside)
        if abs(remaining - planned) > _SAME:
            retime_step(s, foot, s.clock.time + remaining)
            heading = foot_heading(s.command.yaw, s.command.turn_rate, remaining, duration)
        away = heading_vector(heading, x.offset[0], SIDE_SIGN[foot] * x.offset[1])
        set_aim(s, foot, place + away)
    set_target(s, foot, place, nearest_turn(heading, s.swing.reference[foot, 0, YAW]), patch)
    fit_swing(s, foot, c)
    return moved
