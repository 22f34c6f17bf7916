"""A foot that swings now: lifted, carried on, aimed, and moved down when it is late."""

import numpy as np

from drake_linefoot.gait.clock import delay_touchdown, plan_touchdown
from drake_linefoot.gait.contacts import in_contact
from drake_linefoot.gait.footsteps import settle_time
from drake_linefoot.gait.ground import height_of_swing
from drake_linefoot.gait.known_ground import (
    bears,
    height_at,
    highest_between,
    patch_at,
    point_of,
    slope_at,
    was_left,
)
from drake_linefoot.gait.patches import line_on_ground, line_pitch
from drake_linefoot.gait.state import PITCH, SIZE, YAW, GaitConstants, GaitState, Z
from drake_linefoot.gait.swing import Swing, lifted, stepped_motion
from drake_linefoot.gait.told_ground import look_ahead, stand_on
from drake_linefoot.math.compiled import compiled
from drake_linefoot.types import Array

_PUSH = 1.6  # [-] of what takes a lifted foot to the speed of the body within a flight
_HEEL = 0.5  # [rad] so far a foot pitches on its toe after it is lifted in a run
_HEEL_UP = 0.2  # [rad] likewise up a step: its shank leans ahead farther than its ankle bends
_BELOW = 0.5  # [-] of how far a map may be off, down a step
_REACH_AHEAD = 0.005  # [s] a foot that reaches down is planned to stand so soon


@compiled
def present_swing(s: GaitState, foot: int, c: GaitConstants) -> Swing:
    """Return the swing of a foot that is in progress."""
    return Swing(
        s.clock.lift_off[foot],
        s.clock.touchdown[foot],
        s.clock.time,
        s.swing.reference[foot],
        s.swing.target[foot],
        s.swing.height[foot],
        settle_time(s, c),
        s.swing.heel[foot, 0],
        s.swing.heel[foot, 1],
        s.swing.step[foot],
    )


@compiled
def begin_swing(s: GaitState, foot: int, c: GaitConstants) -> None:
    """Begin the swing of a foot where it stands, with nowhere else to go.

    In a run it goes along with the body from the first, or the body would leave it behind.
    """
    line, reference = s.robot.feet[foot], np.zeros((3, SIZE))
    reference[0, :3], reference[0, YAW] = line[:3], line[3]
    reference[0, PITCH] = line_pitch(slope_at(s, int(s.terrain.under[foot])), line[3])
    s.swing.target[foot], s.swing.step[foot] = reference[0], 0.0
    s.swing.lifted[foot] = line[:3]
    if s.command.flight > 0.0:
        along = _PUSH * s.robot.com_velocity[:2] / s.command.flight
        reference[2, :2] = np.minimum(
            np.maximum(along, -c.swing_acceleration[0]), c.swing_acceleration[0]
        )
        s.swing.height[foot] = max(s.swing.height[foot], c.run_swing_height)
    set_heel(s, foot, _HEEL if s.command.flight > 0.0 else c.toe_off, c)
    s.swing.reference[foot] = reference


@compiled
def set_heel(s: GaitState, foot: int, pitch: float, c: GaitConstants) -> None:
    """Let a foot that is lifted pitch on its toe, so far [rad]."""
    s.swing.heel[foot, 0], s.swing.heel[foot, 1] = pitch, c.half_length * pitch


@compiled
def carry_on(s: GaitState, foot: int, dt: float, c: GaitConstants) -> None:
    """Move the reference of a foot that swings on by `dt` [s], towards its target."""
    remaining = s.clock.touchdown[foot] - settle_time(s, c) - s.clock.time
    start, reference, target = s.clock.lift_off[foot], s.swing.reference[foot], s.swing.target[foot]
    done = s.clock.time - start, s.clock.touchdown[foot] - start
    moved = stepped_motion(reference, target, remaining, s.swing.step[foot], done, np.array((dt,)))
    s.swing.reference[foot] = moved[:, 0]


@compiled
def set_target(s: GaitState, foot: int, place: Array, yaw: float, patch: int) -> None:
    """Let a foot that swings land at a place [m], shape (2,), with a heading [rad], on a patch.

    Down a step of which only the map says how far it goes it is to go lower, by half of what that
    may be off: a foot that comes late falls onto the ground, one that meets it early hits it at
    full speed.
    """
    stand_on(s, foot, patch)
    stance = 1 - foot
    s.swing.target[foot] = line_on_ground(
        slope_at(s, patch), point_of(s, patch, stance), place, yaw
    )
    is_below = s.swing.target[foot, Z] < s.robot.feet[stance, Z]
    if is_below and not bears(s, patch, stance) and not was_left(s, patch, foot):
        s.swing.target[foot, Z] -= _BELOW * s.terrain.sigma[patch]


@compiled
def set_aim(s: GaitState, foot: int, aim: Array) -> None:
    """Keep where the DCM is wanted when the weight comes onto a foot [m], shape (2,)."""
    s.swing.aim[foot] = aim


@compiled
def retime_step(s: GaitState, foot: int, end: float) -> None:
    """Plan the touchdown of a foot for another time `end` [s], without a jump of it.

    The bump of the swing has another duration then; the motion below it takes the difference.
    """
    start, height = s.clock.lift_off[foot], s.swing.height[foot]
    elapsed = np.array((s.clock.time - start,))
    heel = s.swing.heel[foot]
    before, _ = lifted(height, heel, s.clock.touchdown[foot] - start, elapsed)
    after, _ = lifted(height, heel, end - start, elapsed)
    for i in range(3):
        s.swing.reference[foot, i, Z] += before[i, 0] - after[i, 0]
    plan_touchdown(s, foot, end)


@compiled
def step_of(s: GaitState, stood: int, stance: int, target: Array, c: GaitConstants) -> float:
    """Return how much a foot goes up or down a step of the ground, see `Swing`.

    Args:
        s: state of the gait.
        stood: patch that it is lifted from.
        stance: a foot that stands.
        target: where it lands [m], x, y, z first.
        c: constants.
    """
    rise = target[Z] - height_at(s, stood, stance, target)
    return min(max(rise / c.swing_height, -1.0), 1.0)


@compiled
def fit_swing(s: GaitState, foot: int, c: GaitConstants) -> None:
    """Let a swing be clear of the edges between where the foot was lifted and where it lands.

    Up a step it goes on its toe first: a foot that is to stay level while its ankle is at its stop
    turns about its middle, toe down, and meets the edge.
    """
    stood = patch_at(s, s.swing.lifted[foot])  # maps change while it swings
    s.swing.step[foot] = step_of(s, stood, 1 - foot, s.swing.target[foot], c)
    if s.clock.time == s.clock.lift_off[foot]:
        pitch = _HEEL_UP * s.swing.step[foot]
        if pitch > s.swing.heel[foot, 0]:
            set_heel(s, foot, pitch, c)
        start, target = s.swing.lifted[foot], s.swing.target[foot]
        above = highest_between(s, start, target) - max(start[Z], target[Z])
        if above > 0.0:
            s.swing.height[foot] = height_of_swing(s.ground.unevenness, c) + above


@compiled
def reach_down(s: GaitState, foot: int, dt: float, c: GaitConstants) -> None:
    """Move a late foot straight down, and expect to stand on it soon."""
    delay_touchdown(s, foot, s.clock.time + _REACH_AHEAD)
    s.swing.reference[foot, 1:] = 0.0
    s.swing.reference[foot, 0, Z] -= c.reach_speed * dt
    s.swing.reference[foot, 1, Z] = -c.reach_speed
    s.swing.target[foot] = s.swing.reference[foot, 0]


@compiled
def fit_height(s: GaitState, landed: int, c: GaitConstants) -> None:
    """Let swings to come be as high and last as long as the ground asks for: a foot has landed."""
    look_ahead(s, landed, c)
    for foot in range(2):
        if foot == landed or in_contact(s, foot):
            s.swing.height[foot] = height_of_swing(s.ground.unevenness, c)
