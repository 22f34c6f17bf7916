"""Patches of ground in plan: where a foot has room on one, and what is the nearest place there.

A patch is a convex polygon, given by its edges ``n . p <= b``. A foot that stands with its middle
at p covers a line, or a sole, about p; all of it is on the patch where p is inside the edges moved
inwards by the foot's reach along each n: the room of the foot. Where the ground beyond an edge is
higher, the shank above the foot leans over it: the toe is farther away there.
"""

import math

import numpy as np

from drake_linefoot.math.compiled import compiled
from drake_linefoot.types import Array

_ROUNDS = 6  # of moving a place inside each edge in turn
_INSIDE = 1e-9  # [m]
_ALONG, _BEYOND = (0.2, 0.5, 0.8), 0.03  # [-], [m] of and from an edge: where a riser is looked for


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
def edges_of(corners: Array, sides: int, out: Array) -> None:
    """Write the edges of a convex polygon, rows ``[n_x, n_y, b]`` with n outwards.

    Args:
        corners: counter-clockwise, of which the first `sides` count [m], shape (m, 2).
        sides: how many.
        out: shape (m, 3).
    """
    for i in range(sides):
        a, b = corners[i], corners[(i + 1) % sides]
        dx, dy = b[0] - a[0], b[1] - a[1]
        length = max(math.hypot(dx, dy), 1e-12)
        out[i, 0], out[i, 1] = dy / length, -dx / length
        out[i, 2] = out[i, 0] * a[0] + out[i, 1] * a[1]


@compiled
def room(edges: Array, yaw: float, size: tuple[float, float], margin: float) -> Array:
    """Return the edges within which the middle of a foot has to be for all of it to be inside.

    Args:
        edges: of a patch, rows ``[n_x, n_y, b]``, shape (m, 3).
        yaw: heading of the foot [rad].
        size: half length and half width of the foot [m].
        margin: from every edge [m].

    Returns:
        Shape (m, 3).
    """
    out, c, s = edges.copy(), math.cos(yaw), math.sin(yaw)
    for i in range(len(edges)):
        along, across = c * out[i, 0] + s * out[i, 1], c * out[i, 1] - s * out[i, 0]
        out[i, 2] -= size[0] * abs(along) + size[1] * abs(across) + margin
    return out


@compiled
def plane_height(plane: Array, place: Array) -> float:
    """Return the height of a plane at a place, x, y first [m].

    Args:
        plane: height at 0 [m], rise along x and y, shape (3,).
        place: [m].
    """
    height: float = plane[0] + plane[1] * place[0] + plane[2] * place[1]
    return height


@compiled
def rises_beyond(patch: int, sides: Array, edges: Array, corners: Array, plane: Array) -> Array:
    """Return how much higher than a patch the ground beyond each of its edges is [m], at least 0.

    Args:
        patch: which of n.
        sides: how many each has, shape (n,).
        edges: of each, see `edges_of`, shape (n, m, 3).
        corners: of this one [m], shape (m, 2).
        plane: of each, height at 0 [m] and rise along x and y, shape (n, 3).

    Returns:
        Shape (m,).
    """
    rises, place, count = np.zeros(len(corners)), np.empty(2), int(sides[patch])
    for i in range(count):
        a, b = corners[i], corners[(i + 1) % count]
        for share in _ALONG:
            for axis in range(2):
                place[axis] = a[axis] + share * (b[axis] - a[axis])
                place[axis] += _BEYOND * edges[patch, i, axis]
            own = plane_height(plane[patch], place)
            for k in range(len(sides)):
                rise, m = plane_height(plane[k], place) - own, int(sides[k])
                if rise > rises[i] and k != patch and m > 0 and is_within(edges[k, :m], place):
                    rises[i] = rise
    return rises


@compiled
def clear_of_risers(
    edges: Array, rises: Array, yaw: float, shank: tuple[float, float, float, float], margin: float
) -> Array:
    """Return edges, those ahead of a foot moved inwards so far that its shank is clear of risers.

    Args:
        edges: of a patch, rows ``[n_x, n_y, b]``, shape (m, 3).
        rises: of the ground beyond each [m], shape (m,).
        yaw: heading of the foot [rad].
        shank: how far the toe is ahead of the ankle, how high that is, and the radius of the
            shank [m]; how far that leans ahead [rad].
        margin: that a foot keeps from every edge [m].

    Returns:
        Shape (m, 3).
    """
    out, (toe, height, radius, lean) = edges.copy(), shank
    for i in range(len(edges)):
        ahead = math.cos(yaw) * out[i, 0] + math.sin(yaw) * out[i, 1]
        if ahead > 0.0 and rises[i] > 0.0:
            front = (rises[i] - height) * math.tan(lean) + radius / math.cos(lean)
            out[i, 2] -= ahead * max(front - toe - margin, 0.0)
    return out


@compiled
def outside(edges: Array, place: Array) -> float:
    """Return how far a place is beyond the edge it is farthest beyond [m]; negative inside."""
    away = -math.inf
    for i in range(len(edges)):
        away = max(away, edges[i, 0] * place[0] + edges[i, 1] * place[1] - edges[i, 2])
    return away


@compiled
def is_within(edges: Array, place: Array, away: float = 0.0) -> bool:
    """Return whether a place is beyond none of the edges, or at most so far `away` [m]."""
    for i in range(len(edges)):
        if edges[i, 0] * place[0] + edges[i, 1] * place[1] - edges[i, 2] > away:
            return False
    return True


@compiled
def moved_inside(edges: Array, place: Array) -> tuple[Array, bool]:
    """Return a place inside edges that is near a place [m], shape (2,), and whether there is one.

    It is the nearest one where an edge, or a corner that is not sharp, is nearest.
    """
    p = np.array((place[0], place[1]))
    for _ in range(_ROUNDS):
        for i in range(len(edges)):
            beyond = edges[i, 0] * p[0] + edges[i, 1] * p[1] - edges[i, 2]
            if beyond > 0.0:
                p[0] -= beyond * edges[i, 0]
                p[1] -= beyond * edges[i, 1]
    return p, len(edges) == 0 or outside(edges, p) < 1e-3


@compiled
def chord(edges: Array, across: float) -> tuple[float, float]:
    """Return between which first coordinates a second one is inside edges [m]; least > most: none.

    Args:
        edges: shape (m, 3).
        across: the second coordinate [m].
    """
    least, most = -math.inf, math.inf
    for i in range(len(edges)):
        n, b = edges[i, 0], edges[i, 2] - edges[i, 1] * across
        if n > 1e-9:
            most = min(most, b / n)
        elif n < -1e-9:
            least = max(least, b / n)
        elif b < -_INSIDE:
            return math.inf, -math.inf
    return least, most


@compiled
def span(edges: Array, axis: int) -> tuple[float, float]:
    """Return the least and the greatest coordinate inside edges [m]; least > most: none.

    Args:
        edges: shape (m, 3).
        axis: of which coordinate, 0 or 1.
    """
    least, most, count = math.inf, -math.inf, len(edges)
    if count == 0:
        return -math.inf, math.inf
    for i in range(count):
        for j in range(i):
            det = edges[i, 0] * edges[j, 1] - edges[i, 1] * edges[j, 0]
            if abs(det) < 1e-9:
                continue
            x = (edges[i, 2] * edges[j, 1] - edges[j, 2] * edges[i, 1]) / det
            y = (edges[i, 0] * edges[j, 2] - edges[j, 0] * edges[i, 2]) / det
            if outside(edges, np.array((x, y))) < 1e-7:
                place = x if axis == 0 else y
                least, most = min(least, place), max(most, place)
    return least, most


@compiled
def seen_from(edges: Array, stance: Array, yaw: float, outward: float) -> Array:
    """Return edges with coordinates forward and outward from a foot, shape (m, 3).

    Args:
        edges: in world, shape (m, 3).
        stance: the foot [m], shape (2,).
        yaw: of forward [rad].
        outward: 1 where outward is to the left, -1 where it is to the right.
    """
    out, c, s = np.empty(edges.shape), math.cos(yaw), math.sin(yaw)
    for i in range(len(edges)):
        n_x, n_y = edges[i, 0], edges[i, 1]
        out[i, 0], out[i, 1] = c * n_x + s * n_y, outward * (c * n_y - s * n_x)
        out[i, 2] = edges[i, 2] - n_x * stance[0] - n_y * stance[1]
    return out
