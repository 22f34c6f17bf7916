"""The ground that standing feet feel, as a plane with a slope."""

import math

import numpy as np

from drake_linefoot.gait.footing import has_full_friction
from drake_linefoot.gait.known_ground import height_at, is_felt
from drake_linefoot.gait.measurement import GaitMeasurement
from drake_linefoot.gait.patches import height_on
from drake_linefoot.gait.state import GaitConstants, GaitState
from drake_linefoot.math.compiled import compiled
from drake_linefoot.types import Array

FELT = 0.02  # [-] a line on level ground rises by a tenth of it when it walks
_OF_A_SLOPE, _OF_TILES = 1.3, 1.6  # [-] shares of `unevenness_max` between which swings get higher
_OF_LAST_STEP = 0.15  # [-] share of it in the unevenness


@compiled
def update_slope_estimate_by_line(
    slope: Array, yaw: float, line_slope: float, share: float, largest: float
) -> Array:
    """Return the slope that rises along a line as the line does; across it, it stays.

    It stays altogether where the line differs by less than its ends sink into the ground.

    Args:
        slope: believed before, shape (2,).
        yaw: heading of the line [rad].
        line_slope: its rise per metre [-].
        share: of the difference that is believed, at most all of it [-].
        largest: bound of both components [-].

    Returns:
        Shape (2,).
    """
    h0, h1 = math.cos(yaw), math.sin(yaw)
    more = line_slope - h0 * slope[0] - h1 * slope[1]
    more *= min(share, 1.0) if abs(more) > FELT else 0.0
    out = np.empty(2)
    out[0] = min(max(slope[0] + h0 * more, -largest), largest)
    out[1] = min(max(slope[1] + h1 * more, -largest), largest)
    return out


@compiled
def pressed_point(line: Array, line_slope: float, along: float) -> Array:
    """Return where a contact line meets the ground [m], shape (3,).

    A foot that lands tilted stands on its heel or its toe, wherever its middle is.

    Args:
        line: [x, y, z, yaw].
        line_slope: its rise per metre of its heading [-].
        along: where its force acts, from its middle along it [m].
    """
    level = along / math.hypot(1.0, line_slope)
    return np.array(
        (
            line[0] + level * math.cos(line[3]),
            line[1] + level * math.sin(line[3]),
            line[2] + level * line_slope,
        )
    )


@compiled
def update_unevenness_estimate(unevenness: float, height: float, touches: Array) -> float:
    """Return how far the last steps met the ground from where it was expected [m].

    Args:
        unevenness: before this step [m].
        height: of the ground there, as it was believed [m].
        touches: where the one that landed meets the ground, shape (3,).
    """
    miss = abs(touches[2] - height)
    return unevenness + _OF_LAST_STEP * (miss - unevenness)


@compiled
def height_of_swing(unevenness: float, c: GaitConstants) -> float:
    """Return the apex of a swing [m]: higher where the ground is uneven, clear of its edges.

    Not so where a slope begins, for there a foot that goes up has to reach the farther for it.

    Args:
        unevenness: see `update_unevenness_estimate` [m].
        c: constants of the gait.
    """
    share = unevenness / c.unevenness_max
    higher = min(max((share - _OF_A_SLOPE) / (_OF_TILES - _OF_A_SLOPE), 0.0), 1.0)
    height: float = c.swing_height + higher * max(c.swing_height_uneven - c.swing_height, 0.0)
    return height


@compiled
def update_slope_estimate_by_feet(
    slope: Array,
    feet: Array,
    side: int,
    lies: Array,
    shares: tuple[float, float],
    largest: float,
    baseline: float,
) -> Array:
    """Return the slope that goes better with how two feet stand.

    Least squares of what the stance foot says along its heading and, with a sole, across it, of
    what the other foot's height says, and of what was believed before.

    Args:
        slope: believed before, shape (2,).
        feet: contact lines of both feet on the ground, [x, y, z, yaw], shape (2, 4).
        side: the foot that has carried weight for long, and lies flat.
        lies: its rise per metre of its heading and to its left [-], shape (2,).
        shares: weight of the feet, and of that to the left, against that of the belief; 0 learns
            nothing.
        largest: bound of both components [-].
        baseline: feet that are nearer to each other tell no slope between them [m].

    Returns:
        Shape (2,).
    """
    a, b, c = 1.0, 0.0, 1.0  # the matrix [[a, b], [b, c]]
    p, q, (share, across) = slope[0], slope[1], shares
    h0, h1 = math.cos(feet[side, 3]), math.sin(feet[side, 3])
    a, b, c = a + share * h0 * h0, b + share * h0 * h1, c + share * h1 * h1
    p, q = p + share * h0 * lies[0], q + share * h1 * lies[0]
    a, b, c = a + across * h1 * h1, b - across * h0 * h1, c + across * h0 * h0
    p, q = p - across * h1 * lies[1], q + across * h0 * lies[1]
    d = feet[1 - side] - feet[side]
    apart = math.hypot(d[0], d[1])
    if apart > baseline:
        u0, u1, between = d[0] / apart, d[1] / apart, d[2] / apart
        a, b, c = a + share * u0 * u0, b + share * u0 * u1, c + share * u1 * u1
        p, q = p + share * u0 * between, q + share * u1 * between
    determinant = a * c - b * b  # at least 1
    out = np.empty(2)
    out[0] = min(max((c * p - b * q) / determinant, -largest), largest)
    out[1] = min(max((a * q - b * p) / determinant, -largest), largest)
    return out


@compiled
def begin_slope(s: GaitState, slope: Array) -> None:
    """Believe a slope, shape (2,), until feet feel another."""
    s.ground.slope[:] = slope


@compiled
def learn_slope(
    s: GaitState, feet: Array, side: int, measured: GaitMeasurement, c: GaitConstants
) -> None:
    """Learn of the slope from two feet on felt ground, of which one has lain flat on it.

    Args:
        s: state of the gait.
        feet: their lines, [x, y, z, yaw], shape (2, 4).
        side: the one that lies flat.
        measured: of the tick.
        c: constants.
    """
    even = s.ground.unevenness <= c.unevenness_max or has_full_friction(
        s.footing.friction_shares[side]
    )
    lies = np.array((measured.line_slope[side], measured.cross_slope[side]))
    share, yaw, slope = c.slope_learning * even, feet[side, 3], s.ground.slope[:]
    if s.command.flight > 0.0:
        share /= 1.0 + (s.ground.unevenness / c.unevenness_max) ** 2
    believed = slope[1] * math.cos(yaw) - slope[0] * math.sin(yaw)
    rolled = c.half_width > 0.0 and abs(lies[1] - believed) > FELT
    s.ground.slope[:] = update_slope_estimate_by_feet(
        slope, feet, side, lies, (share, share if rolled else 0.0), c.slope_max, c.slope_baseline
    )


@compiled
def update_ground_estimate_in_run(
    s: GaitState, measured: GaitMeasurement, c: GaitConstants
) -> None:
    """Learn of both from the stance foot, once it lies flat, and where the other one has stood."""
    side, feet = int(s.clock.side), s.robot.feet.copy()
    if is_felt(s, int(s.terrain.under[side])):
        feet[1 - side, :3] = s.swing.lifted[1 - side]
        expected = height_on(s.ground.slope[:], feet[1 - side], feet[side])
        s.ground.unevenness = update_unevenness_estimate(
            s.ground.unevenness, expected, feet[side, :3]
        )
        learn_slope(s, feet, side, measured, c)


@compiled
def update_ground_estimate_in_stance(
    s: GaitState, measured: GaitMeasurement, c: GaitConstants
) -> None:
    """Learn of the slope from the stance foot, unless it may stand on the edge of a tile.

    The roll of a sole tells of the slope across it as its pitch does of the one along it. In a run
    there is no other time to learn in.
    """
    if s.command.flight > 0.0:
        update_ground_estimate_in_run(s, measured, c)
        return
    side = int(s.clock.side)
    even = s.ground.unevenness <= c.unevenness_max and is_felt(s, int(s.terrain.under[side]))
    if even and abs(measured.vertical_speed[side]) < c.contact_speed:
        yaw, line_slope = s.robot.feet[side, 3], measured.line_slope[side]
        s.ground.slope[:] = update_slope_estimate_by_line(
            s.ground.slope[:], yaw, line_slope, c.slope_learning, c.slope_max
        )
        if c.half_width > 0.0:
            left, cross_slope = yaw + 0.5 * math.pi, measured.cross_slope[side]
            s.ground.slope[:] = update_slope_estimate_by_line(
                s.ground.slope[:], left, cross_slope, c.slope_learning, c.slope_max
            )


@compiled
def update_ground_estimate_at_touchdown(
    s: GaitState, measured: GaitMeasurement, c: GaitConstants
) -> None:
    """Learn of unevenness and slope from a foot that has just landed, and the one that stood."""
    side, foot = int(s.clock.side), 1 - int(s.clock.side)
    touches = pressed_point(s.robot.feet[foot], measured.line_slope[foot], measured.presses[foot])
    patch = int(s.terrain.under[foot])
    expected = height_at(s, patch, side, touches)
    s.ground.unevenness = update_unevenness_estimate(s.ground.unevenness, expected, touches)
    if is_felt(s, patch):
        learn_slope(s, s.robot.feet[:], side, measured, c)
