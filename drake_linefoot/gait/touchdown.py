"""Where the swing foot should land and when, for the CoM of this moment.

`s` is the gait's state in a swing, see `state.GAIT`, and `c` are its constants, see
`gait_constants`.
"""

import math

import numpy as np

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
from drake_linefoot.gait.ground import height_on, line_on_ground
from drake_linefoot.gait.pendulum import dcm, dcm_offset
from drake_linefoot.gait.state import YAW, Z
from drake_linefoot.gait.step_program import PEAK, Step, StepProblem, solve_step
from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.splines import bump
from drake_linefoot.types import Array

LATEST = 1.3  # [-] of a swing: so long it may last where its foot would land too near
_SAME = 1e-9  # [s] between two times that count as equal


@compiled
def place_beside(s: np.record, c: np.record) -> Array:
    """Return the place beside the stance foot where a walk ends [m], shape (2,)."""
    aside = SIDE_SIGN[1 - int(s.side)] * c.step_width
    return s.feet[int(s.side)][:2] + heading_vector(s.yaw, 0.0, aside)


@compiled
def ends_beside(s: np.record, c: np.record) -> bool:
    """Return whether the swing foot, as it is aimed, may be put beside the other to stand."""
    miss = s.target[:2] - place_beside(s, c)
    still = s.velocity[0] == 0.0 and s.velocity[1] == 0.0 and s.turn_rate == 0.0
    return bool(still and math.hypot(miss[0], miss[1]) < c.closing_tolerance)


@compiled
def planned_height(s: np.record) -> tuple[float, float]:
    """Return how high above the ground the swing foot should be now [m], and its climb [m/s]."""
    stance, reference = s.feet[int(s.side)], s.reference
    elapsed = np.array((s.time - s.phase_start,))
    lift = bump(s.swing_height, s.phase_end - s.phase_start, elapsed)
    ground = height_on(s.slope[:], stance, reference[0])
    return reference[0, Z] + lift[0, 0] - ground, reference[1, Z] + lift[1, 0]


@compiled
def soonest(s: np.record, c: np.record) -> float:
    """Return how soon the swing foot may land: it must be lifted, and come down again [s]."""
    elapsed, above = s.time - s.phase_start, max(planned_height(s)[0], 0.0)
    down = math.sqrt(PEAK * above / c.swing_acceleration[2]) + settle_time(s, c)
    return max(down, c.swing_time_min * math.sqrt(s.swing_height / c.swing_height) - elapsed)


@compiled
def foot_acceleration(s: np.record, c: np.record) -> Array:
    """Return the bound of a swing foot's acceleration, forward and to the side [m/s^2], shape (2,).

    It never holds back a steady walk, whose foot swings as far as two steps take it.
    """
    command, left = step_command(s, c), swing_duration(s.velocity[0], c) - settle_time(s, c)
    steady = 2.0 * PEAK * command.duration / left**2 * np.abs(command.velocity)
    return np.maximum(c.swing_acceleration[:2], steady)


@compiled
def step_problem(s: np.record, yaw: float, c: np.record) -> StepProblem:
    """Return the swing as `solve_step` takes it, for a heading at touchdown [rad]."""
    side, command, foot = int(s.side), step_command(s, c), s.reference
    stance, strides = s.feet[side][:2], nominal_strides(command, c, yaw, 1 - side)
    offset = dcm_offset(strides, c.omega, command.duration)
    xi = dcm(s.pendulum_com[:], s.pendulum_velocity[:], c.omega)
    planned, elapsed = s.phase_end - s.time, s.time - s.phase_start
    swing = swing_duration(s.velocity[0], c)
    nominal = swing - elapsed
    return StepProblem(
        seen_from_stance(side, xi - stance, yaw),
        seen_from_stance(side, s.pendulum_com[:2] - stance, yaw),
        seen_from_stance(side, s.com_velocity[:2], yaw),
        seen_from_stance(side, foot[0, :2] - stance, yaw),
        seen_from_stance(side, foot[1, :2], yaw),
        seen_from_stance(side, s.target[:2] - stance, yaw),
        seen_from_stance(side, offset, yaw),
        foot_acceleration(s, c),
        planned,
        nominal,
        min(soonest(s, c), planned),
        max(nominal, planned),
        max(LATEST * swing - elapsed, planned),
        weight_shift(s, c)[1],
        settle_time(s, c),
        seen_from_stance(side, s.lean[:], yaw),
    )


@compiled
def comes_short(x: StepProblem, step: Step, c: np.record) -> bool:
    """Return whether a foothold is `short_step` from where its offset would be nominal.

    Ahead of it, behind it or aside.
    """
    tau, away = math.exp(c.omega * (step.time + x.switch)), 0.0
    for i in range(2):
        away = max(away, abs(x.dcm[i] * tau - x.offset[i] - step.foothold[i]))
    return away >= c.short_step


@compiled
def aim(s: np.record, c: np.record) -> bool:
    """Choose where the swing foot will land, and when, see `step_program`.

    `target`, `phase_end`, `due` and the count of moved footholds change, `reference` when the time
    does, and `hurried` when the step comes short.

    Returns:
        Whether a limit moved the foothold.
    """
    planned, moved = s.phase_end - s.time, False
    stance, duration = s.feet[int(s.side)], step_command(s, c).duration
    heading = foot_heading(s.yaw, s.turn_rate, planned, duration)
    if s.closing:
        place = place_beside(s, c)
    else:
        x = step_problem(s, heading, c)
        step = solve_step(x, c)
        if comes_short(x, step, c):
            s.hurried = c.hurried_steps
        remaining, u, moved = step.time, step.foothold, step.moved
        aside = SIDE_SIGN[1 - int(s.side)] * u[1]
        place = stance[:2] + heading_vector(heading, u[0], aside)
        s.moved_footholds += moved
        if abs(remaining - planned) > _SAME:
            retime_step(s, s.time + remaining, c)
            heading = foot_heading(s.yaw, s.turn_rate, remaining, duration)
    yaw = nearest_turn(heading, s.reference[0, YAW])
    s.target[:] = line_on_ground(s.slope[:], stance, place, yaw)
    return moved


@compiled
def retime_step(s: np.record, end: float, c: np.record) -> None:
    """Plan the touchdown for another time `end` [s], without a jump of the foot.

    The bump of the swing has another duration then; the motion below it takes the difference.
    """
    elapsed = np.array((s.time - s.phase_start,))
    before = bump(s.swing_height, s.phase_end - s.phase_start, elapsed)
    after = bump(s.swing_height, end - s.phase_start, elapsed)
    for i in range(3):
        s.reference[i, Z] += before[i, 0] - after[i, 0]
    s.phase_end = end
    s.due = end
