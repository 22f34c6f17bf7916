"""The shape of the ground: a half space, boxes for a slope, tiles and courses, or given patches.

The robot starts on a pad, z = 0 up to the edge at x = 0.5 m. A slope begins at that edge: a plane
through (0.5, 0, 0), so that a slope to the side meets the edge in a step that grows away from
y = 0. Tiles lie in the plane of pad and slope, raised or lowered along its normal. A ledge is a
step of level ground across the path.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from drake_linefoot.lab.plants.course import Block, course_blocks, spiral_patches
from drake_linefoot.lab.plants.patch_ground import distances, heights, prisms, terrain_of
from drake_linefoot.lab.scenario.scene import Scene
from drake_linefoot.terrain import Terrain
from drake_linefoot.types import Array

EDGE = 0.5  # [m] of the pad: its reach in x, and in y where there are tiles
DEPTH = 1.0  # [m] of slabs
TILE_DEPTH = 0.3  # [m]
_TILES = 1  # stream of random numbers, beside those of the initial state


class Ground:
    """Where the ground is.

    Attributes:
        is_flat: whether it is the half space z <= 0.
        blocks: the boxes it is made of otherwise. No half space is among them: Drake 1.51 dies of
            one beside some hundred boxes (an infinite box in its broad phase).
        prisms: or the corners of the prisms below given patches [m], upper ones first, shape
            (2 n, 3) each.
    """

    def __init__(self, scene: Scene | None = None, seed: int = 0) -> None:
        """Lay out the ground.

        Args:
            scene: its numbers; without, level ground. Slabs reach `visual_size` from the origin, a
                slope twice as far; on a slope, `tiled` counts from its beginning.
            seed: of the heights of the tiles.
        """
        s = scene or Scene()
        ascent = np.array([np.cos(s.slope_heading), np.sin(s.slope_heading)])
        self._gradient = np.tan(s.slope) * ascent
        flat = s.slope == 0.0 and s.step_height == 0.0 and s.ledge_height == 0.0
        given = spiral_patches(s.spiral) if s.spiral else s.patches
        self._given = terrain_of(given) if given else None
        self.prisms = [] if self._given is None else prisms(self._given)
        flat = flat and self._given is None
        self.is_flat = flat and s.course is None
        length, width = s.visual_size[:2]
        patches = [_Patch(np.eye(3), np.zeros(3), (-length, EDGE if s.slope else length), EDGE)]
        if s.ledge_height:
            patches = [
                _Patch(np.eye(3), np.zeros(3), (-length, s.ledge_at), EDGE),
                _Patch(np.eye(3), np.array([0.0, 0.0, s.ledge_height]), (s.ledge_at, length), EDGE),
            ]
        if s.slope:
            axes = slope_axes(s.slope, s.slope_heading)
            patches.append(_Patch(axes, np.array([EDGE, 0.0, 0.0]), (0.0, 2.0 * length), 0.0))
        random = np.random.default_rng([seed, _TILES])
        self.blocks = course_blocks(s.course, seed) if s.course else []
        self._is_course, self._tiled = s.course is not None, s.step_height > 0.0
        for patch in [] if flat or self.prisms else patches:
            slab = patch.box(patch.along, (-width, width), -0.5 * s.step_height, DEPTH)
            self.blocks.append(slab)
            if s.step_height:
                self.blocks += _tiles(patch, s, random)
        if self.blocks:
            R, p, size = (np.array(part) for part in zip(*self.blocks, strict=True))
            self._boxes = R, p, 0.5 * size
            self._middle = p[:, None, :2]
            self._reach = (np.abs(R[:, None, :2]) @ (0.5 * size[:, None, :, None]))[..., 0] + 1e-9

    def plane(self, x: float, y: float) -> float:
        """Return the height of pad and slope without tiles, or of a course where it is nearest."""
        if self._given is not None:
            there = np.array([[x, y]])
            k = int(np.argmin(distances(self._given, there)))
            return float(heights(self._given, there)[0, k])
        if self._is_course:
            R, p, half = self._boxes
            local = np.einsum("kij,ki->kj", R, [x, y, 0.0] - p)[:, :2]
            away = np.maximum(np.abs(local) - half[:, :2], 0.0)
            k = int(np.argmin(np.sum(away * away, axis=1)))
            above, normal = p[k] + half[k, 2] * R[k, :, 2], R[k, :, 2]
            return float(above[2] - normal[:2] @ ([x, y] - above[:2]) / normal[2])
        if x <= EDGE:
            return 0.0
        return float(self._gradient @ [x - EDGE, y])

    def patches(self) -> Terrain:
        """Return all its patches, any number of them."""
        if self._given is not None:
            return self._given
        blocks = [block for block in self.blocks if not self._tiled or block.size[2] < DEPTH]
        if self.is_flat:
            blocks = [Block(np.eye(3), np.array([0.0, 0.0, -0.5]), np.array([200.0, 200.0, 1.0]))]
        corners, plane = np.array([block.corners for block in blocks]), np.empty((len(blocks), 3))
        for k, block in enumerate(blocks):
            rise = -block.R_WB[:2, 2] / block.R_WB[2, 2]
            plane[k] = corners[k, 0, 2] - rise @ corners[k, 0, :2], *rise
        sides, sigma = np.full(len(blocks), 4.0), np.zeros(len(blocks))
        return Terrain(float(len(blocks)), sides, corners[..., :2], plane, sigma)

    def height(self, x: ArrayLike, y: ArrayLike) -> Array:
        """Return the height of the ground [m], the truth that no controller knows.

        Args:
            x: [m], any shape.
            y: [m], the same shape.

        Returns:
            Where a vertical line from above meets the ground, the shape of `x`; -inf beyond it.
        """
        x, y = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
        if self.is_flat:
            return np.zeros(x.shape)
        points = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
        if self._given is not None:
            away, z = (of(self._given, points[:, :2]) for of in (distances, heights))
            return np.where(away <= 1e-9, z, -np.inf).max(axis=1).reshape(x.shape)
        top = np.full(x.size, -np.inf)
        near = np.all(np.abs(points[:, :2] - self._middle) <= self._reach, axis=2)
        for k in np.flatnonzero(np.any(near, axis=1)):
            here = near[k]
            top[here] = np.maximum(top[here], _top(points[here], self.blocks[k]))
        return top.reshape(x.shape)

    def distance(self, points: Array) -> Array:
        """Return how far points are from the ground [m], 0 inside it.

        Args:
            points: x, y, z [m], shape (n, 3).

        Returns:
            Shape (n,); to the side of a given patch that is not level as if it were so there.
        """
        if self.is_flat:
            return np.maximum(points[:, 2], 0.0)
        if self._given is not None:
            away, z = (of(self._given, points[:, :2]) for of in (distances, heights))
            gaps = np.hypot(np.maximum(away, 0.0), np.maximum(points[:, 2:] - z, 0.0))
            nearest: Array = gaps.min(axis=1)
            return nearest
        nearest = np.full(len(points), np.inf)
        for R, p, half in zip(*self._boxes, strict=True):
            away = np.maximum(np.abs((points - p) @ R) - half, 0.0)
            nearest = np.minimum(nearest, np.linalg.norm(away, axis=1))
        return nearest


def slope_axes(slope: float, heading: float) -> Array:
    """Return the axes of the slope as columns, shape (3, 3).

    The third is its normal; the second lies in the edge of the pad, so that a box with these
    axes ends there.
    """
    rise = np.sin(slope) * np.array([np.cos(heading), np.sin(heading)])
    normal = np.array([-rise[0], -rise[1], np.cos(slope)])
    edge = np.array([0.0, np.cos(slope), rise[1]])
    edge /= np.linalg.norm(edge)
    return np.column_stack([np.cross(edge, normal), edge, normal])


class _Patch(NamedTuple):
    """A plane with a rectangle on it."""

    R: Array  # its axes, shape (3, 3)
    origin: Array  # [m], shape (3,)
    along: tuple[float, float]  # reach of the rectangle along the first axis [m]
    first: float  # where along that axis a tile begins [m]

    def box(
        self, along: tuple[float, float], across: tuple[float, float], top: float, depth: float
    ) -> Block:
        """Return a box below a rectangle, its top over the plane."""
        size = np.array([along[1] - along[0], across[1] - across[0], depth])
        middle = [0.5 * sum(along), 0.5 * sum(across), top - 0.5 * depth]
        return Block(self.R, self.origin + self.R @ middle, size)


def _tiles(patch: _Patch, scene: Scene, random: np.random.Generator) -> Iterator[Block]:
    """Yield the tiles of a patch, row by row.

    On the one of the pad, tiles in reach of the robot's start are level.
    """
    is_pad, tile, reach = not patch.origin.any(), scene.tile, 0.5 * np.asarray(scene.tiled)
    low, high = max(-reach[0], patch.along[0]), min(reach[0], patch.along[1])
    for i in range(_first(low, patch.first, tile), _first(high, patch.first, tile)):
        for j in range(_first(-reach[1], 0.0, tile), _first(reach[1], 0.0, tile)):
            u, v = patch.first + i * tile, j * tile
            height = scene.step_height * random.uniform(-0.5, 0.5)
            nearest = np.maximum(0.0, np.abs([u + 0.5 * tile, v + 0.5 * tile]) - 0.5 * tile)
            if is_pad and nearest.max() < EDGE - 1e-9:
                height = 0.0
            yield patch.box((u, u + tile), (v, v + tile), height, TILE_DEPTH)


def _first(at: float, line: float, tile: float) -> int:
    """Return which tile is the first to begin at or beyond a place; tile 0 begins at `line`."""
    return int(np.ceil((at - line) / tile - 1e-9))


def _top(points: Array, block: Block) -> Array:
    """Return where vertical lines through points, shape (n, 3), enter a box from above [m].

    They miss it where that is -inf, shape (n,).
    """
    R, p, size = block
    begin, way = (points - p) @ R, -R[2]  # along the box's axes, downwards
    way = np.where(np.abs(way) < 1e-12, 1e-12, way)  # nearly along a side, and so far to its ends
    half = 0.5 * size + np.array([1e-9, 1e-9, 0.0])  # no gap between neighbours
    ends = (np.array([-half, half])[:, None] - begin) / way
    enter, leave = ends.min(axis=0).max(axis=1), ends.max(axis=0).min(axis=1)
    return np.where(enter <= leave + 1e-9, points[:, 2] - enter, -np.inf)
