"""The ground that is known: patches of a map, or the one that feet feel, and what feet correct."""

import math

import numpy as np

from drake_linefoot.gait.patches import (
    clear_of_risers,
    height_on,
    is_within,
    moved_inside,
    outside,
    plane_height,
    room,
)
from drake_linefoot.gait.state import GaitConstants, GaitState, Z
from drake_linefoot.math.compiled import compiled
from drake_linefoot.types import Array

_BEHIND = 2.0  # [-] what a place behind counts more: the nearest one stalls at an edge for ever
_DOWN = 0.4  # [-] of a step down, by which the CoM stays above where it would be on the lower foot
BETWEEN = 12  # places on the way of a foot at which it is looked how high the ground is
_MET = 2.0  # [-] of `late_contact_height`: a foot that is stopped higher has met an edge
_LOW_IN_A_RUN = 0.6  # [-] of the height of a swing, likewise where the ground is felt
_FAST = 10.0  # [-] of `contact_speed`: a foot that is not to stop and does has met the ground


@compiled
def edges_at(s: GaitState, patch: int) -> Array:
    """Return the edges of a patch, shape (sides, 3)."""
    edges: Array = s.terrain.edges[patch, : int(s.terrain.sides[patch])]
    return edges


@compiled
def is_felt(s: GaitState, patch: int) -> bool:
    """Return whether nothing is known of a patch but what feet feel."""
    return bool(s.terrain.sides[patch] == 0.0)


@compiled
def slope_at(s: GaitState, patch: int) -> Array:
    """Return the slope of a patch, shape (2,)."""
    if is_felt(s, patch):
        return np.array((s.ground.slope[0], s.ground.slope[1]))
    return np.array((s.terrain.plane[patch, 1], s.terrain.plane[patch, 2]))


@compiled
def slopes_of(s: GaitState) -> Array:
    """Return the slope of the ground under each foot, or where it lands, shape (2, 2)."""
    slopes = np.empty((2, 2))
    for foot in range(2):
        slopes[foot] = slope_at(s, int(s.terrain.under[foot]))
    return slopes


@compiled
def bears(s: GaitState, patch: int, stance: int) -> bool:
    """Return whether the stance foot is on a patch, as it always is on ground that is felt."""
    return is_felt(s, patch) or bool(s.terrain.under[stance] == patch)


@compiled
def was_left(s: GaitState, patch: int, foot: int) -> bool:
    """Return whether a foot was lifted from a patch last."""
    return patch_at(s, s.swing.lifted[foot]) == patch


@compiled
def point_of(s: GaitState, patch: int, stance: int) -> Array:
    """Return a point of a patch [m], shape (3,): where a foot is or was on it, else of the map."""
    if bears(s, patch, stance):
        foot = s.robot.feet[stance]
        return np.array((foot[0], foot[1], foot[2]))
    if was_left(s, patch, 1 - stance):
        left = s.swing.lifted[1 - stance]
        return np.array((left[0], left[1], left[2]))
    return np.array((0.0, 0.0, s.terrain.plane[patch, 0] + s.terrain.offset))


@compiled
def height_at(s: GaitState, patch: int, stance: int, place: Array) -> float:
    """Return the height of a patch at a place, x, y first [m]."""
    return height_on(slope_at(s, patch), point_of(s, patch, stance), place)


@compiled
def mapped_height(s: GaitState, patch: int, place: Array) -> float:
    """Return the height that the map gives a patch at a place, x, y first [m]."""
    return plane_height(s.terrain.plane[patch], place)


@compiled
def patch_at(s: GaitState, place: Array) -> int:
    """Return the patch that a point x, y, z [m] is on, or is nearest to."""
    best, found = math.inf, 0
    for k in range(int(s.terrain.count)):
        if is_felt(s, k):
            away = 0.0
        else:
            plane = s.terrain.plane[k]
            above = place[2] - plane[0] - plane[1] * place[0] - plane[2] * place[1]
            away = max(outside(edges_at(s, k), place), 0.0) + abs(above - s.terrain.offset)
        if away < best:
            best, found = away, k
    return found


@compiled
def room_of(s: GaitState, patch: int, yaw: float, c: GaitConstants) -> Array:
    """Return the room of a foot with a heading [rad] on a patch, see `room`, shape (sides, 3)."""
    margin, edges = c.edge_margin + s.terrain.sigma[patch], edges_at(s, patch)
    shank = (c.toe[0], c.toe[1], c.shank_radius, c.shank_lean)
    clear = clear_of_risers(edges, s.terrain.rises[patch], yaw, shank, margin)
    return room(clear, yaw, (c.half_length, c.half_width), margin)


@compiled
def snapped(s: GaitState, place: Array, yaw: float, c: GaitConstants) -> tuple[Array, int]:
    """Return where ground has room for a foot that is to be at a place, and the patch.

    Places behind count double.

    Args:
        s: state of the gait.
        place: x, y [m], shape (2,).
        yaw: heading of the foot [rad].
        c: constants of the gait.

    Returns:
        (place, patch): shape (2,).
    """
    nearest, best = 0, math.inf
    for k in range(int(s.terrain.count)):
        if is_felt(s, k):
            return place.copy(), k
        away = outside(edges_at(s, k), place)
        if away < best:
            nearest, best = k, away
    best, where, found = math.inf, place.copy(), 0
    h_x, h_y = math.cos(yaw), math.sin(yaw)
    for i in range(-1, int(s.terrain.count)):
        k = i if i >= 0 else nearest  # first: it spares most of the others
        if i == nearest or not is_within(edges_at(s, k), place, best):
            continue
        there, is_inside = moved_inside(room_of(s, k, yaw, c), place)
        dx, dy = there[0] - place[0], there[1] - place[1]
        away = math.hypot(dx, dy)
        if dx * h_x + dy * h_y < 0.0:
            away *= _BEHIND
        if is_inside and (away < best or (away == best and k < found)):
            best, where, found = away, there, k
    return where, found


@compiled
def is_known_at(s: GaitState, patch: int, place: Array) -> bool:
    """Return whether a patch is known and has a place within its edges [m], shape (2,)."""
    return not is_felt(s, patch) and is_within(edges_at(s, patch), place)


@compiled
def highest_between(s: GaitState, one: Array, other: Array) -> float:
    """Return how high known ground is on the straight way between two places, at most [m].

    Minus infinity where none is known.

    Args:
        s: state of the gait.
        one: x, y first [m].
        other: likewise.
    """
    highest, place = -math.inf, np.empty(2)
    for i in range(BETWEEN):
        share = (i + 0.5) / BETWEEN
        place[0] = one[0] + share * (other[0] - one[0])
        place[1] = one[1] + share * (other[1] - one[1])
        for k in range(int(s.terrain.count)):
            if is_known_at(s, k, place):
                highest = max(highest, mapped_height(s, k, place) + s.terrain.offset)
    return highest


@compiled
def level_between(stance: float, landing: float) -> float:
    """Return from where the height of the CoM counts while a foot goes to another height [m].

    The leg that stays behind is to reach the ground: it is the lower foot, and down a step less.

    Args:
        stance: height of the foot that stands [m].
        landing: of the one that lands [m].
    """
    return min(stance, landing) + _DOWN * max(stance - landing, 0.0)


@compiled
def is_near_patch(s: GaitState, foot: int, line: Array, rate: float, c: GaitConstants) -> bool:
    """Return whether a foot that has stopped is not so far above ground that it met an edge.

    Ground that is felt may be anywhere. But in a run, at the apex of its swing, what the other foot
    takes from the ground is easily taken for its own; so there it is to be low, or to have come
    down fast.

    Args:
        s: state of the gait.
        foot: that swings.
        line: where it is measured, [x, y, z, yaw].
        rate: at which it should rise now [m/s].
        c: constants.
    """
    patch = int(s.terrain.under[foot])
    if is_felt(s, patch):
        above = line[Z] - s.swing.target[foot, Z]
        low, fast = _LOW_IN_A_RUN * s.swing.height[foot], -_FAST * c.contact_speed
        return s.command.flight == 0.0 or above < low or rate < fast
    above = line[Z] - height_at(s, patch, 1 - foot, line)
    return bool(above < _MET * c.late_contact_height + s.terrain.sigma[patch])
