"""What is kept of the ground: a map that is told, what feet correct of it, and where they stand."""

import math

import numpy as np

from drake_linefoot.gait.contacts import in_contact
from drake_linefoot.gait.footsteps import heading_vector
from drake_linefoot.gait.ground import begin_slope
from drake_linefoot.gait.known_ground import BETWEEN, is_felt, is_known_at, mapped_height, patch_at
from drake_linefoot.gait.patches import edges_of, is_within, rises_beyond
from drake_linefoot.gait.state import GaitConstants, GaitState, Z
from drake_linefoot.math.compiled import compiled
from drake_linefoot.terrain import CORNERS, Terrain, open_terrain
from drake_linefoot.types import Array

_OPEN = 2.0  # [-] heights of the CoM: where no edge is nearer to a foot, none binds strides ahead
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
    """Return the patch that both feet are on if it has no edge near them; -1 without one."""
    for k in range(len(edges)):
        m, away = int(t.sides[k]), _OPEN * c.com_height + t.sigma[k]
        left = m > 0 and is_within(edges[k, :m], s.robot.feet[0], -away)
        if left and is_within(edges[k, :m], s.robot.feet[1], -away):
            return k
    return -1


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
