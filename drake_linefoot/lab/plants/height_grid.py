"""Patches of a grid of heights: regions that are plane, cut into convex pieces.

A cell is flat where a plane through it and its neighbours fits. Flat cells that touch are looked
through for the largest plane, again and again; cells beside it that lie in it are of it as well. A
region that is not convex is cut. A patch is the hull of the middles of its cells: it lies within
what was measured.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy.ndimage import binary_propagation, label
from scipy.spatial import ConvexHull

from drake_linefoot.lab.scenario.courses import STEEPEST
from drake_linefoot.terrain import CORNERS, Terrain
from drake_linefoot.types import Array

FLAT = 0.004  # [m] rms of nine cells about a plane
NEAR = 0.015  # [m] from a plane to a cell that is of it
SEEDS, AROUND = 24, 3  # planes that are tried; cells about each that say it
COMMON = 0.95  # share of cells that `sigma` holds for
NARROWEST = 3  # cells of a patch along its shorter side

Cells = NDArray[np.int64]  # indices along x and y, shape (n, 2)


class HeightGrid(NamedTuple):
    """Heights of the ground in the middles of square cells."""

    heights: Array  # [m], shape (n, m), along x and y; NaN: not known
    cell: float  # [m]
    origin: Array  # x and y of the middle of the first cell [m], shape (2,)


def patches_of(grid: HeightGrid) -> Terrain:
    """Return the patches of a grid, any number; `sigma` is how far most cells are from theirs."""
    found = []
    for cells, plane in _regions(grid):
        for piece in _convex_pieces(cells):
            hull = _few_corners(piece[ConvexHull(piece).vertices])
            off = np.quantile(_off(grid, piece, plane), COMMON)
            found.append((grid.origin + grid.cell * hull, plane, float(off)))
    corners, sides = np.empty((len(found), CORNERS, 2)), np.empty(len(found))
    for k, (hull, _, _) in enumerate(found):
        sides[k], corners[k] = len(hull), hull[0]
        corners[k, : len(hull)] = hull
    planes = np.array([plane for _, plane, _ in found]).reshape(-1, 3)
    sigma = np.array([off for *_, off in found])
    return Terrain(float(len(found)), sides, corners, planes, sigma)


def _lift(grid: HeightGrid, cells: Cells) -> Array:
    """Return rows [1, x, y] of cells, shape (n, 3)."""
    return np.column_stack([np.ones(len(cells)), grid.origin + grid.cell * cells])


def _off(grid: HeightGrid, cells: Cells, plane: Array) -> Array:
    """Return how far cells are above or below a plane [m], shape (n,)."""
    off: Array = np.abs(_lift(grid, cells) @ plane - grid.heights[*cells.T])
    return off


def _regions(grid: HeightGrid) -> Iterator[tuple[Cells, Array]]:
    """Yield cells that touch and lie in a plane, and it."""
    known = np.isfinite(grid.heights)
    free, every = known.copy(), np.argwhere(known)
    regions = _touching(np.argwhere(_flat(grid.heights)))
    while regions:
        cells = regions.pop()
        if not _is_broad(cells):
            continue
        plane = _largest_plane(grid, cells)
        is_in = _off(grid, cells, plane) <= NEAR
        parts = _touching(cells[is_in])
        region = max(parts, key=len)
        regions += [part for part in parts if part is not region]
        regions += _touching(cells[~is_in])
        if not _is_broad(region) or np.hypot(*plane[1:]) > STEEPEST:
            continue
        # Cells at an edge are not flat, those in the plane are of the region all the same.
        mask, may = np.zeros(known.shape, dtype=bool), np.zeros(known.shape, dtype=bool)
        mask[*region.T] = True
        may[*every[_off(grid, every, plane) <= NEAR].T] = True
        mask = binary_propagation(mask, mask=may & free)
        free &= ~mask
        regions = [part[free[*part.T]] for part in regions]
        yield np.argwhere(mask), plane


def _largest_plane(grid: HeightGrid, cells: Cells) -> Array:
    """Return the plane that most cells lie in: that of all, or about one of them, shape (3,)."""
    best, found = 0, np.zeros(3)
    seeds = cells[np.linspace(0, len(cells) - 1, SEEDS).astype(int)]
    near = [cells[np.abs(cells - seed).max(axis=1) <= AROUND] for seed in seeds]
    for first in (cells, *near):
        some = first
        for _ in range(2):  # once more with all that lie in it
            plane = np.linalg.lstsq(_lift(grid, some), grid.heights[*some.T])[0]
            some = cells[is_in := _off(grid, cells, plane) <= NEAR]
            if is_in.sum() > best:
                best, found = int(is_in.sum()), plane
            if is_in.all() or not is_in.any():
                break
        if best == len(cells):
            break
    return found


def _flat(z: Array) -> NDArray[np.bool_]:
    """Return where a plane through a cell and its eight neighbours is near to all of them."""
    around = np.array([[1.0, i, j] for i in (-1, 0, 1) for j in (-1, 0, 1)])
    off = np.eye(9) - around @ np.linalg.pinv(around)
    windows = sliding_window_view(z, (3, 3)).reshape(-1, 9)
    flat = np.zeros(z.shape, dtype=bool)
    inner = np.sqrt(np.mean((windows @ off) ** 2, axis=1)) <= FLAT  # False where one is NaN
    flat[1:-1, 1:-1] = inner.reshape(z.shape[0] - 2, -1)
    return flat


def _touching(cells: Cells) -> list[Cells]:
    """Return cells in parts of which the cells touch by their sides."""
    if not len(cells):
        return []
    low = cells.min(axis=0)
    mask = np.zeros(cells.max(axis=0) - low + 1, dtype=bool)
    mask[*(cells - low).T] = True
    labels, count = label(mask)
    of = labels[*(cells - low).T]
    return [cells[of == k + 1] for k in range(count)]


def _is_broad(cells: Cells) -> bool:
    """Return whether cells may make a patch: broad enough along x, y and their axes."""
    if len(cells) < NARROWEST**2 or np.ptp(cells, axis=0).min() < NARROWEST - 1:
        return False
    along = (cells - cells.mean(axis=0)) @ _axes(cells)
    return bool(np.ptp(along, axis=0).min() >= NARROWEST - 1)


def _axes(cells: Cells) -> Array:
    """Return the axes along which cells reach least and farthest, as columns."""
    away = cells - cells.mean(axis=0)
    axes: Array = np.linalg.eigh(away.T @ away)[1]
    return axes


def _convex_pieces(cells: Cells) -> Iterator[Cells]:
    """Yield parts of cells whose hulls hold no other cells."""
    parts = _touching(cells)
    while parts:
        part = parts.pop()
        if not _is_broad(part):
            continue
        strange = _strangers(part)
        if not len(strange):
            yield part
            continue
        # Cut along one of its axes through a cell of the hull that is not its own: where the
        # larger of what is left has the fewest such.
        cuts = []
        for axis in (*_axes(part).T, *np.eye(2)):
            along, through = part @ axis, strange @ axis
            for at in np.quantile(through, [0.0, 0.5, 1.0]):
                for first in (along < at - 1e-9, along <= at + 1e-9):
                    if 0 < first.sum() < len(part):
                        halves = [part[first], part[~first]]
                        left = sum(len(_strangers(half)) for half in halves)
                        cuts.append((left, abs(2 * int(first.sum()) - len(part)), halves))
        if cuts:
            parts += [p for half in min(cuts, key=lambda c: c[:2])[2] for p in _touching(half)]


def _strangers(cells: Cells) -> Cells:
    """Return the cells within the hull of cells that are none of them."""
    if not _is_broad(cells):
        return np.empty((0, 2), dtype=np.int64)
    hull = ConvexHull(cells).equations
    low, high = cells.min(axis=0), cells.max(axis=0)
    own = np.zeros(high - low + 1, dtype=bool)
    own[*(cells - low).T] = True
    others = np.argwhere(~own) + low
    inside: Cells = others[(others @ hull[:, :2].T + hull[:, 2] <= 1e-9).all(axis=1)]
    return inside


def _few_corners(hull: Array) -> Array:
    """Return a polygon of at most 8 corners inside a convex one, of most of its area."""
    while len(hull) > CORNERS:
        before, after = np.roll(hull, 1, axis=0) - hull, np.roll(hull, -1, axis=0) - hull
        lost = np.abs(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0])
        hull = np.delete(hull, int(np.argmin(lost)), axis=0)
    return hull
