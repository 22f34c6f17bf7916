"""Where the swing foot should land and when, for the CoM of this moment.

`s` is the gait's state in a swing, see `state.GAIT`, and `c` are its constants, see
`gait_constants`.
"""

import math

import numpy as np

from drake_linefoot.gait.footsteps import (
    SIDE_SIGN,
    clip_foothold,
    foot_heading,
    heading_vector,
    nearest_turn,
    next_foothold,
    step_command,
)
from drake_linefoot.gait.ground import line_on_ground
from drake_linefoot.gait.pendulum import dcm, propagate_com, propagate_dcm
from drake_linefoot.gait.state import YAW, Z
from drake_linefoot.gait.swing import base_motion
from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.splines import bump
from drake_linefoot.types import Array

_MOMENTS = np.array([0.0, 0.21, 0.5, 0.79, 1.0])  # [-] of a motion, where it may be fastest


@compiled
def place_beside(s: np.record, c: np.record) -> Array:
    """Return the place beside the stance foot where a walk ends [m], shape (2,)."""
    aside = SIDE_SIGN[1 - int(s.side)] * c.step_width
    return s.feet[int(s.side)][:2] + heading_vector(s.yaw, 0.0, aside)


@compiled
def swing_target(s: np.record, remaining: float, c: np.record) -> tuple[Array, bool]:
    """Return where the swing foot should land `remaining` [s] from now.

    Returns:
        (target, moved): [x, y, z, pitch, yaw], shape (5,), and whether a limit moved it.
    """
    side, stance, command = 1 - int(s.side), s.feet[int(s.side)], step_command(s, c)
    com, com_velocity, cop, omega = s.com[:], s.com_velocity[:], stance[:2], c.omega
    xi_now = dcm(com, s.pendulum_velocity[:], omega)
    heading = foot_heading(s.yaw, s.turn_rate, remaining, command.duration)
    if s.closing:
        place, moved = place_beside(s, c), False
    else:
        xi = propagate_dcm(xi_now, cop, omega, remaining + c.switch)
        place, short = next_foothold(xi, cop, heading, side, command, c)
        landing = propagate_com(com, com_velocity, cop, omega, remaining)
        place, far = clip_foothold(place, landing, heading, side, c.reach_limits[:])
        moved = short or far
    yaw = nearest_turn(heading, s.reference[0, YAW])
    return line_on_ground(s.slope[:], stance, place, yaw), moved


@compiled
def peak_acceleration(reference: Array, target: Array, duration: float) -> float:
    """Return the largest horizontal acceleration on the way to a target, of five moments [m/s^2].

    Args:
        reference: position, velocity, acceleration now, shape (3, 5).
        target: where the motion comes to rest, shape (5,).
        duration: of the motion [s].
    """
    motion = base_motion(reference, target, duration, duration * _MOMENTS)
    peak = 0.0
    for i in range(len(_MOMENTS)):
        peak = max(peak, math.hypot(motion[2, i, 0], motion[2, i, 1]))
    return peak


@compiled
def aim(s: np.record, c: np.record) -> None:
    """Choose where the swing foot will land, and when: sooner while a limit moves its foothold.

    `target`, `phase_end`, `due` and the count of moved footholds change, and `reference` when the
    step is shortened: by `step_time_decrement` again and again, as long as enough time is left
    and the foot is not accelerated too much.
    """
    planned = remaining = s.phase_end - s.time
    shortest = max(c.remaining_time_min, s.phase_start + c.swing_time_min - s.time)
    decrement = c.step_time_decrement
    target, moved = swing_target(s, remaining, c)
    while moved and decrement > 0.0 and remaining - decrement >= shortest:
        sooner = remaining - decrement
        nearer, far = swing_target(s, sooner, c)
        peak = peak_acceleration(s.reference[:], nearer, sooner - c.settle_time)
        if peak > c.swing_acceleration_max:
            break
        target, moved, remaining = nearer, far, sooner
    s.target[:] = target
    s.moved_footholds += moved
    if remaining != planned:
        shorten_step(s, s.time + remaining, c)


@compiled
def shorten_step(s: np.record, end: float, c: np.record) -> None:
    """Plan the touchdown for another time `end` [s], without a jump of the foot.

    The bump of the swing has another duration then; the motion below it takes the difference.
    """
    elapsed = np.array((s.time - s.phase_start,))
    before = bump(c.swing_height, s.phase_end - s.phase_start, elapsed)
    after = bump(c.swing_height, end - s.phase_start, elapsed)
    for i in range(3):
        s.reference[i, Z] += before[i, 0] - after[i, 0]
    s.phase_end = end
    s.due = end
