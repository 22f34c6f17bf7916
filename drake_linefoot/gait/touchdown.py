"""Where a foot that swings should land and when, for the CoM of this moment."""

import math

import numpy as np

from drake_linefoot.gait.contacts import in_final_step
from drake_linefoot.gait.footsteps import (
    SIDE_SIGN,
    foot_heading,
    heading_vector,
    nearest_turn,
    nominal_strides,
    seen_from_stance,
    settle_time,
    step_command,
    swing_duration,
    weight_shift,
)
from drake_linefoot.gait.ground import height_on
from drake_linefoot.gait.pendulum import dcm, dcm_offset
from drake_linefoot.gait.recovery import is_insufficient, note_step
from drake_linefoot.gait.state import YAW, GaitConstants, GaitState, Z
from drake_linefoot.gait.step_program import PEAK, StepProblem, solve_step
from drake_linefoot.gait.swing import lifted
from drake_linefoot.gait.swing_foot import retime_step, set_target
from drake_linefoot.math.compiled import compiled
from drake_linefoot.types import Array

LATEST = 1.3  # [-] of a swing: so long it may last where its foot would land too near
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
    stance, reference = s.robot.feet[1 - foot], s.swing.reference[foot]
    start, end = s.clock.lift_off[foot], s.clock.touchdown[foot]
    elapsed = np.array((s.clock.time - start,))
    lift, _ = lifted(s.swing.height[foot], s.swing.heel[foot], end - start, elapsed)
    ground = height_on(s.ground.slope[:], stance, reference[0])
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
    command, left = step_command(s, c), swing_duration(s.command.velocity[0], c) - settle_time(s, c)
    steady = 2.0 * PEAK * command.duration / left**2 * np.abs(command.velocity)
    return np.maximum(c.swing_acceleration[:2], steady)


@compiled
def step_problem(s: GaitState, foot: int, yaw: float, c: GaitConstants) -> StepProblem:
    """Return the swing of a foot as `solve_step` takes it, for a heading at touchdown [rad]."""
    side, command, motion = 1 - foot, step_command(s, c), s.swing.reference[foot]
    stance, strides = s.robot.feet[side][:2], nominal_strides(command, c, yaw, 1 - side)
    offset = dcm_offset(strides, c.omega, command.duration)
    xi = dcm(s.robot.pendulum_com[:], s.robot.pendulum_velocity[:], c.omega)
    time, start, end = s.clock.time, s.clock.lift_off[foot], s.clock.touchdown[foot]
    planned, elapsed = end - time, time - start
    swing = swing_duration(s.command.velocity[0], c)
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
    )


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
        place = place_beside(s, foot, c)
    else:
        x = step_problem(s, foot, heading, c)
        step = solve_step(x, c)
        note_step(s, is_insufficient(x, step, c), step.moved, c)
        remaining, u, moved = step.time, step.foothold, step.moved
        aside = SIDE_SIGN[foot] * u[1]
        place = stance[:2] + heading_vector(heading, u[0], aside)
        if abs(remaining - planned) > _SAME:
            retime_step(s, foot, s.clock.time + remaining)
            heading = foot_heading(s.command.yaw, s.command.turn_rate, remaining, duration)
    set_target(s, foot, place, nearest_turn(heading, s.swing.reference[foot, 0, YAW]))
    return moved
