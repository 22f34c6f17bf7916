"""The ground that standing feet feel, as a plane with a slope."""

import math

import numpy as np

from drake_linefoot.contact.wrench_cone import forces_at_ends, ground_frame
from drake_linefoot.gait.state import SWING
from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.linear import dot
from drake_linefoot.math.rotation import cross
from drake_linefoot.types import Array

FELT = 0.02  # [-] a line on level ground rises by a tenth of it when it walks
_OF_A_SLOPE, _OF_TILES = 1.3, 1.6  # [-] shares of `unevenness_max` between which swings get higher
_OF_LAST_STEP = 0.15  # [-] share of it in the unevenness
_OF_LAST_SLIP = 0.3  # [-] share of it in the slip
_OF_SLIDING = 0.05  # [-] share of what a tick tells in the friction
_AGAINST = 0.9  # [-] cosine of the angle between friction and what it is against
_OF_THE_LOAD = 0.3  # [-] an end that bears less of it tells nothing
_LEAST_FRICTION = 0.3  # [-] less is not believed
_REGAINED = 1.01  # [-] by a step that does not slide


@compiled
def line_pitch(slope: Array, yaw: float) -> float:
    """Return the pitch of a contact line that lies on the ground [rad]; up is negative.

    Args:
        slope: rise per metre along x and y of the world, shape (2,).
        yaw: heading of the line [rad].
    """
    return -math.atan(slope[0] * math.cos(yaw) + slope[1] * math.sin(yaw))


@compiled
def height_on(slope: Array, known: Array, place: Array) -> float:
    """Return the height of the ground at a place [m].

    Args:
        slope: rise per metre along x and y of the world, shape (2,).
        known: a point of the ground, x, y, z first [m].
        place: x, y first [m].
    """
    height: float = known[2] + slope[0] * (place[0] - known[0]) + slope[1] * (place[1] - known[1])
    return height


@compiled
def line_on_ground(slope: Array, known: Array, place: Array, yaw: float) -> Array:
    """Return a contact line on the ground, [x, y, z, pitch, yaw], shape (5,).

    Args:
        slope: rise per metre along x and y of the world, shape (2,).
        known: a point of the ground, x, y, z first [m].
        place: middle of the line, x, y first [m].
        yaw: heading of the line [rad].
    """
    height = height_on(slope, known, place)
    return np.array((place[0], place[1], height, line_pitch(slope, yaw), yaw))


@compiled
def feel_slope(slope: Array, yaw: float, rise: float, share: float, largest: float) -> Array:
    """Return the slope that rises along a line as the line does; across it, it stays.

    It stays altogether where the line differs by less than its ends sink into the ground.

    Args:
        slope: believed before, shape (2,).
        yaw: heading of the line [rad].
        rise: of the line per metre [-].
        share: of the difference that is believed, at most all of it [-].
        largest: bound of both components [-].

    Returns:
        Shape (2,).
    """
    h0, h1 = math.cos(yaw), math.sin(yaw)
    more = rise - h0 * slope[0] - h1 * slope[1]
    more *= min(share, 1.0) if abs(more) > FELT else 0.0
    out = np.empty(2)
    out[0] = min(max(slope[0] + h0 * more, -largest), largest)
    out[1] = min(max(slope[1] + h1 * more, -largest), largest)
    return out


@compiled
def learn_unevenness(unevenness: float, slope: Array, stance: Array, landed: Array) -> float:
    """Return how far the last steps met the ground from where it was expected [m].

    Args:
        unevenness: before this step [m].
        slope: that was believed, shape (2,).
        stance: contact line of the foot that stood, x, y, z first [m].
        landed: of the one that landed, likewise.
    """
    miss = abs(landed[2] - height_on(slope, stance, landed))
    return unevenness + _OF_LAST_STEP * (miss - unevenness)


@compiled
def height_of_swing(unevenness: float, c: np.record) -> float:
    """Return the apex of a swing [m]: higher where the ground is uneven, clear of its edges.

    Not so where a slope begins, for there a foot that goes up has to reach the farther for it.

    Args:
        unevenness: see `learn_unevenness` [m].
        c: constants of the gait.
    """
    share = unevenness / c.unevenness_max
    higher = min(max((share - _OF_A_SLOPE) / (_OF_TILES - _OF_A_SLOPE), 0.0), 1.0)
    rise: float = c.swing_height + higher * max(c.swing_height_uneven - c.swing_height, 0.0)
    return rise


@compiled
def present_slip(s: np.record) -> float:
    """Return how far the stance foot of a swing has slid since it began [m]; else 0."""
    if s.mode != SWING:
        return 0.0
    foot = s.feet[int(s.side)]
    return math.hypot(foot[0] - s.planted[0], foot[1] - s.planted[1])


@compiled
def learn_slip(slip: float, slid: float) -> float:
    """Return how far the stance feet of the last steps slid [m], by a step that `slid` so far."""
    return slip + _OF_LAST_SLIP * (slid - slip)


@compiled
def learn_friction(
    friction: float,
    motion: tuple[Array, Array],
    wrench: Array,
    R_WC: Array,
    slope: Array,
    c: np.record,
) -> float:
    """Return the friction of the ground that the heel and the toe of a foot tell that slide [-].

    An end that slides is pulled against its motion by friction times its share of the normal force.
    Mostly the foot turns about the other end, so that its whole force tells nothing.

    Args:
        friction: believed before.
        motion: velocity of the middle of the line [m/s] and angular velocity of the foot [rad/s],
            shape (3,) each.
        wrench: on it, forces in W and torques in C [N, N m], shape (5,).
        R_WC: contact frame, shape (3, 3).
        slope: of the ground, rise per metre along x and y of the world, shape (2,).
        c: constants of the gait.
    """
    v, w = motion
    R, X = ground_frame(R_WC, slope), c.half_length
    tau, in_ground = wrench[3] * R_WC[:, 1] + wrench[4] * R_WC[:, 2], np.empty(5)
    for i in range(3):
        in_ground[i] = dot(R[:, i], wrench)
    in_ground[3], in_ground[4] = dot(R[:, 1], tau), dot(R[:, 2], tau)
    forces, f_z, turning = forces_at_ends(in_ground, X), in_ground[2], X * cross(w, R[:, 0])
    for i in (1, 0):  # toe, heel
        ahead, aside, normal = forces[i]
        if normal <= _OF_THE_LOAD * f_z or f_z <= 0.0:
            continue
        u = v + (2.0 * i - 1.0) * turning
        u_x, u_y = dot(R[:, 0], u), dot(R[:, 1], u)
        speed, pull = math.hypot(u_x, u_y), math.hypot(ahead, aside)
        if speed > c.contact_speed and -(ahead * u_x + aside * u_y) > _AGAINST * pull * speed:
            friction += _OF_SLIDING * (min(pull / normal, 1.0) - friction)
    return max(friction, _LEAST_FRICTION)


@compiled
def regain_friction(friction: float, slid: float, c: np.record) -> float:
    """Return the friction that is believed after a step that `slid` [m]: more if it did not."""
    return friction if slid > c.slip_max else min(_REGAINED * friction, 1.0)


@compiled
def learn_slope(
    slope: Array,
    feet: Array,
    side: int,
    rise: float,
    share: float,
    largest: float,
    baseline: float,
) -> Array:
    """Return the slope that goes better with how two feet stand.

    Least squares of what the line of the stance foot says along its heading, of what the other
    foot's height says, and of what was believed before.

    Args:
        slope: believed before, shape (2,).
        feet: contact lines of both feet on the ground, [x, y, z, yaw], shape (2, 4).
        side: the foot that has carried weight for long, and lies flat.
        rise: of its line per metre [-].
        share: weight of the feet against that of the belief; 0 learns nothing.
        largest: bound of both components [-].
        baseline: feet that are nearer to each other tell no slope between them [m].

    Returns:
        Shape (2,).
    """
    a, b, c = 1.0, 0.0, 1.0  # the matrix [[a, b], [b, c]]
    p, q = slope[0], slope[1]
    h0, h1 = math.cos(feet[side, 3]), math.sin(feet[side, 3])
    a, b, c = a + share * h0 * h0, b + share * h0 * h1, c + share * h1 * h1
    p, q = p + share * h0 * rise, q + share * h1 * rise
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
