"""Ground of given patches: prisms below convex polygons, each with a plane on top."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from drake_linefoot.lab.scenario.courses import PatchParameters
from drake_linefoot.terrain import CORNERS, Terrain
from drake_linefoot.types import Array

DEPTH = 1.0  # [m] of a prism below its lowest corner


def terrain_of(patches: Sequence[PatchParameters]) -> Terrain:
    """Return any number of patches as a `Terrain`; unused corners are the first one."""
    corners, sides = np.empty((len(patches), CORNERS, 2)), np.empty(len(patches))
    for k, patch in enumerate(patches):
        given = patch.counter_clockwise
        sides[k], corners[k] = len(given), given[0]
        corners[k, : len(given)] = given
    planes = np.array([patch.plane for patch in patches], dtype=float)
    return Terrain(float(len(patches)), sides, corners, planes, np.zeros(len(patches)))


class Outlines(NamedTuple):
    """The edges of n patches of up to m edges; of one with fewer its first stands for the others.

    Attributes:
        patches: that have them.
        corners: x and y of where each begins [m], shape (2, m, n).
        outwards: its normal, shape (2, m, n).
    """

    patches: Terrain
    corners: Array
    outwards: Array

    def distances(self, places: Array) -> Array:
        """Return how far places are beyond the farthest edge of each, see `distances`."""
        (x, y), away = places.T[..., None], np.full((len(places), self.corners.shape[2]), -np.inf)
        for edge in range(self.corners.shape[1]):
            (at_x, at_y), (n_x, n_y) = self.corners[:, edge], self.outwards[:, edge]
            np.maximum(away, (x - at_x) * n_x + (y - at_y) * n_y, out=away)
        return away


def outlines(patches: Terrain) -> Outlines:
    """Return the edges of patches."""
    corners = patches.corners
    way = np.roll(corners, -1, axis=1) - corners
    length = np.hypot(*way.T).T
    is_edge = length > 0.0  # no corner that is not used
    outwards = np.stack([way[..., 1], -way[..., 0]], axis=-1)
    outwards /= np.where(is_edge, length, 1.0)[..., None]
    first = np.argmax(is_edge, axis=1)[:, None]
    which = np.where(is_edge, np.arange(corners.shape[1]), first)[..., None]
    used = which[:, np.any(is_edge, axis=0)]
    each = (np.take_along_axis(of, used, axis=1).T for of in (corners, outwards))
    return Outlines(patches, *map(np.ascontiguousarray, each))


def distances(patches: Terrain, places: Array) -> Array:
    """Return how far places are beyond the farthest edge of patches [m]; negative inside.

    Args:
        patches: n of them.
        places: x, y first [m], shape (m, 2).

    Returns:
        Shape (m, n).
    """
    return outlines(patches).distances(places)


def heights(patches: Terrain, places: Array) -> Array:
    """Return the heights of the planes of patches at places [m], shapes as of `distances`."""
    planes: Array = patches.plane[:, 0] + places @ patches.plane[:, 1:].T
    return planes


def prisms(patches: Terrain) -> list[Array]:
    """Return the corners of the prisms below patches [m], upper ones first, shape (2 n, 3) each."""
    found = []
    for sides, corners, plane in zip(patches.sides, patches.corners, patches.plane, strict=True):
        given = corners[: int(sides)]
        top = plane[0] + given @ plane[1:]
        below = np.full(len(given), top.min() - DEPTH)
        found.append(np.vstack([np.column_stack([given, z]) for z in (top, below)]))
    return found
