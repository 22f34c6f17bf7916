"""Compiled: what the gait does in every tick, on its state as a vector.

The names below say where in the vector each field of `GaitState` stands.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.gait.footstep_kernels import (
    SIDE_SIGN,
    StepShape,
    foot_heading,
    heading_vector,
    nearest_turn,
)
from drake_linefoot.gait.ground_kernels import height_on, line_pitch
from drake_linefoot.gait.swing_kernels import (
    SIZE,
    YAW,
    Z,
    contact_lines,
    next_reference,
    present_line,
)
from drake_linefoot.gait.target_kernels import timed_target
from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.polynomial_kernels import bump

Array = NDArray[np.float64]

STAND, SHIFT, SWING, DOUBLE = 0, 1, 2, 3  # values of `Mode`

TIME, MODE, SIDE, CLOSING, PHASE_START, PHASE_END, DUE = 0, 1, 2, 3, 4, 5, 6
HEADING, TURN_RATE, STEPS, MOVED, CLIPPED = 7, 8, 9, 10, 11
VELOCITY, SCALE, OFFSET, MARKS, COM, COM_VELOCITY = 12, 14, 16, 18, 24, 27
FEET, TARGET, REFERENCE, SLOPE, END = 30, 38, 43, 58, 60

TIME_EPSILON = 1e-9  # [s]
_TICKS = 0.002  # [s] durations are multiples of it, so that phases end at a tick


class TickConstants(NamedTuple):
    """The constants of a tick; fields of `GaitParameters` where they have its names.

    Attributes:
        limits: of the command, forward, left, turn [m/s, m/s, rad/s].
        rates: of its change [m/s^2, m/s^2, rad/s^2].
        contact_feedback: whether contact ends a swing.
        early_contact_phase: [-] share of the swing before which it does not.
        single_support: [s].
        single_support_min: [s].
        double_support: [s].
        step_length: [m].
        step_width: [m].
        swing_height: [m].
        settle_time: [s].
        last_aim: before touchdown, from when on the foothold moves no more [s].
        step_time_decrement: [s].
        remaining_time_min: [s].
        swing_time_min: [s].
        swing_acceleration_max: [m/s^2].
        switch: of the CoP after touchdown [s].
    """

    limits: tuple[float, float, float]
    rates: tuple[float, float, float]
    contact_feedback: bool
    early_contact_phase: float
    single_support: float
    single_support_min: float
    double_support: float
    step_length: float
    step_width: float
    swing_height: float
    settle_time: float
    last_aim: float
    step_time_decrement: float
    remaining_time_min: float
    swing_time_min: float
    swing_acceleration_max: float
    switch: float


@compiled
def swing_duration(forward: float, c: TickConstants) -> float:
    """Return how long a single support lasts at a commanded forward velocity [m/s], in s.

    At speed it is shortened so that a step is not longer than `step_length`: the leg that
    stays behind would come to the end of its ankle or of its knee.
    """
    speed = abs(forward)
    if speed * (c.single_support + c.double_support) <= c.step_length:
        return c.single_support
    short = _TICKS * round((c.step_length / speed - c.double_support) / _TICKS)
    return max(short, min(c.single_support_min, c.single_support))


@compiled
def follow_command(state: Array, command: Array, dt: float, c: TickConstants) -> None:
    """Clip and rate-limit the command, and turn the desired heading with it, in place.

    Args:
        state: of the gait, shape (END,).
        command: [v_x, v_y, turn rate, walk] [m/s, m/s, rad/s, 0 or 1], shape (4,).
        dt: [s].
        c: constants.
    """
    desired, now, clipped = np.empty(3), np.empty(3), False
    now[:2], now[2] = state[VELOCITY:SCALE], state[TURN_RATE]
    for i in range(3):
        desired[i] = min(max(command[i], -c.limits[i]), c.limits[i])
        clipped = clipped or desired[i] != command[i]
    state[CLIPPED] += clipped
    if state[MODE] == STAND or command[3] <= 0.5:
        desired[:] = 0.0
    if now[0] != desired[0] or now[1] != desired[1] or now[2] != desired[2]:
        for i in range(3):
            most = c.rates[i] * dt
            now[i] += min(max(desired[i] - now[i], -most), most)
        state[VELOCITY:SCALE], state[TURN_RATE] = now[:2], now[2]
    if state[MODE] != STAND:
        state[HEADING] += state[TURN_RATE] * dt


@compiled
def aim(state: Array, c: TickConstants, shape: StepShape) -> None:
    """Choose where the swing foot will land, and when, if that is out of reach, in place.

    Args:
        state: of the gait in a swing, shape (END,): `target`, `phase_end`, `due` and the count of
            moved footholds change, and `reference` with them.
        c: constants.
        shape: of a step at the slowest pace; its duration is not used.
    """
    side = int(state[SIDE])
    stance = state[FEET:TARGET].reshape(2, 4)[side]
    reference = state[REFERENCE:SLOPE].reshape(3, SIZE)
    yaw, turn_rate, slope = state[HEADING], state[TURN_RATE], state[SLOPE:END]
    remaining = state[PHASE_END] - state[TIME]
    duration = swing_duration(state[VELOCITY], c) + c.double_support
    if state[CLOSING] != 0.0:
        place = stance[:2] + heading_vector(yaw, 0.0, SIDE_SIGN[1 - side] * c.step_width)
        heading = foot_heading(yaw, turn_rate, remaining, duration)
        state[TARGET : TARGET + 2] = place
        state[TARGET + Z] = height_on(slope, stance, place)
        state[TARGET + YAW] = nearest_turn(heading, reference[0, YAW])
        state[TARGET + YAW - 1] = line_pitch(slope, state[TARGET + YAW])
        return
    here = StepShape(
        duration, shape.width, shape.omega, shape.length_max, shape.width_min, shape.width_max,
        shape.reach_forward, shape.reach_outward,
    )  # fmt: skip
    shortest = max(c.remaining_time_min, state[PHASE_START] + c.swing_time_min - state[TIME])
    target, moved, sooner = timed_target(
        state[COM:COM_VELOCITY], state[COM_VELOCITY:FEET], stance, reference, remaining, shortest,
        c.step_time_decrement, c.settle_time, c.swing_acceleration_max, c.switch, yaw, 1 - side,
        state[VELOCITY:SCALE], state[SCALE:OFFSET], state[OFFSET:MARKS], turn_rate, slope, here,
    )  # fmt: skip
    state[TARGET:REFERENCE] = target
    state[MOVED] += moved
    if sooner != remaining:
        shorten_step(state, state[TIME] + sooner, c.swing_height)


@compiled
def present(state: Array, height: float) -> tuple[Array, Array, Array]:
    """Return what the whole-body controller needs of a swing, and the command.

    Args:
        state: of the gait, shape (END,).
        height: of the bump [m].

    Returns:
        (motion, foothold, command): rows of `present_line`, shape (6, 3), and [x, y, z, yaw],
        shape (4,), NaN when no foot swings; [v_x, v_y, turn rate] after limits, shape (3,).
    """
    motion, place, command = np.full((6, 3), np.nan), np.full(4, np.nan), np.empty(3)
    if state[MODE] == SWING:
        start, reference = state[PHASE_START], state[REFERENCE:SLOPE].reshape(3, SIZE)
        motion = present_line(reference, height, state[DUE] - start, state[TIME] - start)
        place[:3], place[3] = state[TARGET : TARGET + 3], state[TARGET + YAW]
    command[:2], command[2] = state[VELOCITY:SCALE], state[TURN_RATE]
    return motion, place, command


@compiled
def shorten_step(state: Array, end: float, height: float) -> None:
    """Plan the touchdown for another time, without a jump of the foot, in place.

    The bump of the swing has another duration then; the motion below it takes the difference.

    Args:
        state: of the gait in a swing, shape (END,).
        end: [s].
        height: of the bump [m].
    """
    start = state[PHASE_START]
    t = np.array([state[TIME] - start])
    before = bump(height, state[PHASE_END] - start, t)
    after = bump(height, end - start, t)
    reference = state[REFERENCE:SLOPE].reshape(3, SIZE)
    for i in range(3):
        reference[i, Z] += before[i, 0] - after[i, 0]
    state[PHASE_END] = end
    state[DUE] = end


@compiled
def carry_on(
    before: Array,
    command: Array,
    com: Array,
    com_velocity: Array,
    feet: Array,
    contact: tuple[bool, bool],
    time: float,
    c: TickConstants,
    shape: StepShape,
) -> tuple[Array, bool]:
    """Advance a state within its phase.

    Args:
        before: the state at an earlier time, shape (END,).
        command: [v_x, v_y, turn rate, walk], shape (4,).
        com: measured at `time` [m], shape (3,).
        com_velocity: [m/s], shape (3,).
        feet: contact lines [x, y, z, yaw], shape (2, 4).
        contact: what the contact estimator says of each foot.
        time: [s].
        c: constants.
        shape: of a step.

    Returns:
        (state, ended): at `time`, shape (END,), and whether the phase may be over: then
        nothing is decided yet, nor is a swing foot aimed.
    """
    state, dt = before.copy(), time - before[TIME]
    mode, side = int(before[MODE]), int(before[SIDE])
    follow_command(state, command, dt, c)
    state[TIME] = time
    state[COM:COM_VELOCITY] = com
    state[COM_VELOCITY:FEET] = com_velocity
    stands = state[FEET:TARGET].reshape(2, 4)
    for foot in range(2):
        if mode != SWING or foot == side:
            stands[foot] = feet[foot]
    over = time >= state[PHASE_END] - TIME_EPSILON
    if mode == STAND:
        return state, command[3] > 0.5
    if mode != SWING:
        return state, over or (mode == SHIFT and command[3] <= 0.5)
    reference = before[REFERENCE:SLOPE].reshape(3, SIZE)
    remaining = before[PHASE_END] - c.settle_time - before[TIME]
    moved = next_reference(reference, before[TARGET:REFERENCE], remaining, dt)
    state[REFERENCE:SLOPE] = moved.reshape(3 * SIZE)
    if c.contact_feedback:
        share = (time - state[PHASE_START]) / (state[DUE] - state[PHASE_START])
        found = contact[1 - side] and share >= c.early_contact_phase
        over = over or found or time >= state[DUE] - TIME_EPSILON
    if not over and state[PHASE_END] - time > c.last_aim:
        aim(state, c, shape)
    return state, over


@compiled
def carry_on_lines(
    before: Array,
    command: Array,
    com: Array,
    com_velocity: Array,
    lines: Array,
    R_WC: Array,
    contact: tuple[bool, bool],
    time: float,
    c: TickConstants,
    shape: StepShape,
) -> tuple[Array, bool]:
    """Do what `carry_on` does, with `lines` and `R_WC` of `RobotDynamics` for the feet."""
    feet, _ = contact_lines(lines, R_WC)
    return carry_on(before, command, com, com_velocity, feet, contact, time, c, shape)
