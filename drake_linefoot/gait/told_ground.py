"""What is kept of the ground: a map that is told, what feet correct of it, and where they stand."""

import math

import numpy as np

from drake_linefoot.gait.contacts import in_contact
from drake_linefoot.gait.footsteps import heading_vector
from drake_linefoot.gait.ground import begin_slope
from drake_linefoot.gait.known_ground import BETWEEN, is_felt, is_known_at, mapped_height, patch_at
from drake_linefoot.gait.patches import edges_of, is_within, plane_height, rises_beyond
from drake_linefoot.gait.state import GaitConstants, GaitState, Z
from drake_linefoot.math.compiled import compiled
from drake_linefoot.terrain import CORNERS, Terrain, open_terrain
from drake_linefoot.types import Array

_OPEN = 2.0  # [-] heights of the CoM: where no edge is nearer to a foot, none binds strides ahead
_FLUSH = 1e-3  # [m] that patches may be apart, or differ in height, where they meet in a seam
_SLOWEST = 1e-9  # [m/s] a command that is slower has no direction
_CORRECTED = 0.5  # [-] of what a foot that lands says of the height of the map


@compiled
def told_edges(t: Terrain) -> Array:
    """Return the edges of each patch, see `edges_of`; of those that a patch has not zeros."""
    edges = np.zeros((int(t.number), CORNERS, 3))
    for k in range(len(edges)):
        edges_of(t.corners[k], int(t.sides[k]), edges[k])
    return edges


@compiled
def open_patch(s: GaitState, t: Terrain, edges: Array, c: GaitConstants) -> int:
    """Return the patch that the left foot is on if no edge of the map is near a foot; else -1.

    A seam, beyond which the ground goes on at the same height, is no edge.
    """
    on = -1
    for k in range(len(edges)):
        m = int(t.sides[k])
        if m > 0 and is_within(edges[k, :m], s.robot.feet[0]):
            on = k
        for i in range(m):
            for foot in range(2):
                if has_edge_near(t, edges, k, i, s.robot.feet[foot], _OPEN * c.com_height):
                    return -1
    return on


@compiled
def has_edge_near(t: Terrain, edges: Array, patch: int, i: int, place: Array, reach: float) -> bool:
    """Return whether the part of an edge of a patch that is near a place is no seam.

    Args:
        t: the map.
        edges: of its patches, shape (n, m, 3).
        patch: which of them.
        i: which edge of it.
        place: x, y first [m].
        reach: what is near, in addition to how far the patch may be off [m].
    """
    edge, a = edges[patch, i], t.corners[patch, i]
    reach += t.sigma[patch]
    away = edge[0] * place[0] + edge[1] * place[1] - edge[2]
    if abs(away) > reach:
        return False
    b = t.corners[patch, (i + 1) % int(t.sides[patch])]
    half = math.sqrt(reach**2 - away**2)
    middle = edge[0] * (place[1] - a[1]) - edge[1] * (place[0] - a[0])  # along it, from its begin
    length = edge[0] * (b[1] - a[1]) - edge[1] * (b[0] - a[0])
    near = max(middle - half, 0.0), min(middle + half, length)
    return near[0] <= near[1] and not is_seam(t, edges, patch, i, near)


@compiled
def is_seam(t: Terrain, edges: Array, patch: int, i: int, part: tuple[float, float]) -> bool:
    """Return whether one other patch goes on at the same height beyond a part of an edge.

    Args:
        t: the map.
        edges: of its patches, shape (n, m, 3).
        patch: which of them.
        i: which edge of it.
        part: from where to where, along the edge from its beginning [m].
    """
    edge, begin = edges[patch, i], t.corners[patch, i]
    for k in range(len(edges)):
        m, goes_on = int(t.sides[k]), k != patch
        for along in part:
            place = np.array((begin[0] - along * edge[1], begin[1] + along * edge[0]))
            step = plane_height(t.plane[k], place) - plane_height(t.plane[patch], place)
            goes_on = goes_on and abs(step) < _FLUSH and m > 0
            goes_on = goes_on and is_within(edges[k, :m], place, _FLUSH)
        if goes_on:
            return True
    return False


@compiled
def take_in_terrain(s: GaitState, vector: Array, c: GaitConstants) -> None:
    """Keep the patches of a `Terrain`, as it travels; find those on which feet stand, or will.

    Where no edge is near the robot feels its way, as without a map: there that takes harder pushes.
    It begins with the slope that the map says.

    Args:
        s: state of the gait.
        vector: a `Terrain`.
        c: constants.
    """
    t = open_terrain(vector)
    edges = told_edges(t)
    on = open_patch(s, t, edges, c)
    if on < 0:
        keep_patches(s, t, edges)
    else:
        if not is_felt(s, 0):
            begin_slope(s, t.plane[on, 1:])
        s.terrain.count, s.terrain.sides[0], s.terrain.plane[0], s.terrain.sigma[0] = 1.0, 0, 0, 0
    for foot in range(2):
        line = s.robot.feet[foot] if in_contact(s, foot) else s.swing.target[foot]
        s.terrain.under[foot] = patch_at(s, line)


@compiled
def keep_patches(s: GaitState, t: Terrain, edges: Array) -> None:
    """Keep the patches of a map, with their edges and what rises beyond those."""
    known, n = s.terrain, len(edges)
    is_new = known.count != t.number or np.any(known.plane != t.plane)
    is_new = is_new or np.any(known.sides != t.sides)
    known.count = t.number
    known.sides[:], known.plane[:], known.sigma[:] = t.sides, t.plane, t.sigma
    for k in range(n):
        m = int(t.sides[k])
        is_new = is_new or np.any(s.terrain.edges[k, :m] != edges[k, :m])
        s.terrain.edges[k, :m] = edges[k, :m]
    if is_new:
        outlines = t.sides[:n], s.terrain.edges[:n]
        for k in range(n):
            s.terrain.rises[k] = rises_beyond(k, *outlines, t.corners[k], t.plane[:n])


@compiled
def correct_heights(s: GaitState, foot: int) -> None:
    """Learn from a foot that has landed how far the map is off."""
    patch = int(s.terrain.under[foot])
    if not is_felt(s, patch):
        place = s.robot.feet[foot]
        miss = place[2] - mapped_height(s, patch, place) - s.terrain.offset
        s.terrain.offset += _CORRECTED * miss


@compiled
def look_ahead(s: GaitState, stance: int, c: GaitConstants) -> None:
    """See how much per metre known ground rises or falls over the next two steps, at most.

    Args:
        s: state of the gait.
        stance: the foot that has landed.
        c: constants.
    """
    velocity, foot = s.command.velocity, s.robot.feet[stance]
    speed = max(math.hypot(velocity[0], velocity[1]), _SLOWEST)
    way = heading_vector(s.command.yaw, velocity[0] / speed, velocity[1] / speed)
    s.terrain.steep = 0.0
    for i in range(BETWEEN):
        away = 2.0 * c.step_length * (i + 1) / BETWEEN
        place = foot[:2] + away * way
        for k in range(int(s.terrain.count)):
            if is_known_at(s, k, place):
                rise = abs(mapped_height(s, k, place) + s.terrain.offset - foot[Z])
                s.terrain.steep = max(s.terrain.steep, rise / max(away, c.step_length))


@compiled
def stand_on(s: GaitState, foot: int, patch: int) -> None:
    """Keep on which patch a foot is to stand."""
    s.terrain.under[foot] = patch


@compiled
def set_level(s: GaitState, level: float) -> None:
    """Keep from where the height of the CoM counts [m], see `level_between`."""
    s.terrain.level = level
