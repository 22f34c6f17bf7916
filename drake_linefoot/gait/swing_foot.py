"""The swing foot of this moment: lifted, carried on, aimed, and moved down when it is late."""

import numpy as np

from drake_linefoot.gait.clock import go_on_until, land_at
from drake_linefoot.gait.footsteps import settle_time
from drake_linefoot.gait.ground import height_of_swing, line_on_ground, line_pitch
from drake_linefoot.gait.state import PITCH, YAW, GaitConstants, GaitState, Z
from drake_linefoot.gait.swing import Swing, base_motion
from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.splines import bump
from drake_linefoot.types import Array

_REACH_AHEAD = 0.005  # [s] a foot that reaches down is planned to stand so soon


@compiled
def present_swing(s: GaitState, c: GaitConstants) -> Swing:
    """Return the swing in progress."""
    return Swing(
        s.clock.phase_start,
        s.clock.phase_end,
        s.clock.time,
        s.swing.reference[:],
        s.swing.target[:],
        s.swing.height,
        settle_time(s, c),
    )


@compiled
def lift_foot(s: GaitState, foot: int) -> None:
    """Begin the swing of a foot where it stands, with nowhere else to go."""
    line = s.robot.feet[foot]
    s.swing.reference[:] = 0.0
    s.swing.reference[0, :3], s.swing.reference[0, YAW] = line[:3], line[3]
    s.swing.reference[0, PITCH] = line_pitch(s.ground.slope[:], line[3])
    s.swing.target[:] = s.swing.reference[0]


@compiled
def carry_on(s: GaitState, dt: float, c: GaitConstants) -> None:
    """Move the reference of the swing foot on by `dt` [s], towards its target."""
    remaining = s.clock.phase_end - settle_time(s, c) - s.clock.time
    moved = base_motion(s.swing.reference[:], s.swing.target[:], remaining, np.array((dt,)))
    s.swing.reference[:] = moved[:, 0]


@compiled
def aim_at(s: GaitState, place: Array, yaw: float) -> None:
    """Let the swing foot land at a place [m], shape (2,), with a heading [rad]."""
    stance = s.robot.feet[int(s.clock.side)]
    s.swing.target[:] = line_on_ground(s.ground.slope[:], stance, place, yaw)


@compiled
def retime_step(s: GaitState, end: float) -> None:
    """Plan the touchdown for another time `end` [s], without a jump of the foot.

    The bump of the swing has another duration then; the motion below it takes the difference.
    """
    start = s.clock.phase_start
    elapsed = np.array((s.clock.time - start,))
    before = bump(s.swing.height, s.clock.phase_end - start, elapsed)
    after = bump(s.swing.height, end - start, elapsed)
    for i in range(3):
        s.swing.reference[i, Z] += before[i, 0] - after[i, 0]
    land_at(s, end)


@compiled
def reach_down(s: GaitState, dt: float, c: GaitConstants) -> None:
    """Move a late foot straight down, and plan to stand on it soon."""
    go_on_until(s, s.clock.time + _REACH_AHEAD)
    s.swing.reference[1:] = 0.0
    s.swing.reference[0, Z] -= c.reach_speed * dt
    s.swing.reference[1, Z] = -c.reach_speed
    s.swing.target[:] = s.swing.reference[0]


@compiled
def fit_height(s: GaitState, c: GaitConstants) -> None:
    """Let swings be as high as the ground asks for."""
    s.swing.height = height_of_swing(s.ground.unevenness, c)
