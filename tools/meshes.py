"""Small smooth meshes from a few numbers: super-ellipse sections lofted along an axis.

A section is [t, u, v, a, b, n]: station t along the axis, centre (u, v), half widths a and b, and
the exponent n of |x/a|^n + |y/b|^n = 1 (2 is an ellipse, larger is boxier). For axis z, (u, v) is
(x, y); for x it is (y, z); for y it is (z, x). Lengths are in metres.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

Array = NDArray[np.float64]

POINTS_PER_RING = 24
RINGS_PER_SPAN = 2
FILLET_ANGLES = np.radians([0.0, 30.0, 60.0, 90.0])


@dataclass(frozen=True)
class Mesh:
    """A surface of triangles and quadrilaterals with one normal per vertex.

    Attributes:
        vertices: positions in m, shape (k, 3).
        normals: unit outward normals, shape (k, 3).
        faces: vertex numbers from 0, counter-clockwise seen from outside.
    """

    vertices: Array
    normals: Array
    faces: tuple[tuple[int, ...], ...]


def loft(axis: str, sections: Sequence[Sequence[float]], fillet: Sequence[float]) -> Mesh:
    """Lofts a closed surface through sections and rounds its two ends.

    Args:
        axis: "x", "y" or "z".
        sections: rows [t, u, v, a, b, n] with increasing t.
        fillet: rounding radius at the first and at the last section in m, both positive.

    Returns:
        The closed surface.

    Raises:
        ValueError: if a fillet is not positive or does not fit its section.
    """
    table = np.array(sections, dtype=float)
    for radius, row in zip(fillet, (table[0], table[-1]), strict=True):
        if not 0.0 < radius < min(row[3], row[4]):
            raise ValueError(f"fillet {radius} m does not fit the section {row.tolist()}")
    stations, insets = _stations(table[:, 0], fillet)
    shape = PchipInterpolator(table[:, 0], table[:, 1:])(stations)
    shape[:, 2:4] -= insets[:, None]
    rings = _rings(stations, shape)
    shift = {"z": 0, "x": 1, "y": 2}[axis]  # cyclic: keeps the orientation
    grid = np.roll(rings, shift, axis=2)
    return _closed_surface(grid, np.roll(np.array([0.0, 0.0, 1.0]), shift))


def _stations(knots: Array, fillet: Sequence[float]) -> tuple[Array, Array]:
    """Returns the stations of all rings and how far each ring is inset by the fillets."""
    first, last = knots[0] + fillet[0], knots[-1] - fillet[1]
    inner = np.concatenate([np.linspace(lo, hi, RINGS_PER_SPAN + 1) for lo, hi in pairwise(knots)])
    inner = np.unique(inner[(inner > first + 1e-4) & (inner < last - 1e-4)].round(6))
    start = knots[0] + fillet[0] * (1.0 - np.cos(FILLET_ANGLES))
    end = knots[-1] - fillet[1] * (1.0 - np.cos(FILLET_ANGLES[::-1]))
    insets = np.concatenate(
        [
            fillet[0] * (1.0 - np.sin(FILLET_ANGLES)),
            np.zeros(len(inner)),
            fillet[1] * (1.0 - np.sin(FILLET_ANGLES[::-1])),
        ]
    )
    return np.concatenate([start, inner, end]), insets


def _rings(t: Array, shape: Array) -> Array:
    """Returns the points of all rings for axis z, shape (rings, points, 3)."""
    u, v, a, b, n = shape.T
    angle = 2.0 * np.pi * (np.arange(POINTS_PER_RING) + 0.5) / POINTS_PER_RING
    c, s = np.cos(angle), np.sin(angle)
    power = (2.0 / n)[:, None]
    x = u[:, None] + a[:, None] * np.sign(c) * np.abs(c) ** power
    y = v[:, None] + b[:, None] * np.sign(s) * np.abs(s) ** power
    return np.stack([x, y, np.broadcast_to(t[:, None], x.shape)], axis=2)


def _closed_surface(grid: Array, direction: Array) -> Mesh:
    """Joins the rings, adds a flat cap at both ends and estimates the normals."""
    count, points, _ = grid.shape
    around = np.roll(grid, -1, axis=1) - np.roll(grid, 1, axis=1)
    normals = np.cross(around, np.gradient(grid, axis=0))
    normals[0], normals[-1] = -direction, direction  # the fillets end tangent to the caps
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)

    nxt = np.roll(np.arange(points), -1)
    faces: list[tuple[int, ...]] = []
    for row in range(count - 1):
        lo, hi = row * points, (row + 1) * points
        faces += [(lo + i, lo + int(nxt[i]), hi + int(nxt[i]), hi + i) for i in range(points)]
    bottom, top, last = count * points, count * points + 1, (count - 1) * points
    faces += [(bottom, int(nxt[i]), i) for i in range(points)]
    faces += [(top, last + i, last + int(nxt[i])) for i in range(points)]
    centres = np.stack([grid[0].mean(axis=0), grid[-1].mean(axis=0)])
    return Mesh(
        np.concatenate([grid.reshape(-1, 3), centres]),
        np.concatenate([normals.reshape(-1, 3), [-direction, direction]]),
        tuple(faces),
    )


def mirrored(mesh: Mesh) -> Mesh:
    """Returns the mirror image in the plane y = 0, its faces turned outwards again."""
    flip = np.array([1.0, -1.0, 1.0])
    faces = tuple(tuple(reversed(face)) for face in mesh.faces)
    return Mesh(mesh.vertices * flip, mesh.normals * flip, faces)


def obj_text(mesh: Mesh, comment: str) -> str:
    """Writes a mesh as Wavefront OBJ, 0.01 mm resolution, the same bytes every time."""
    lines = [f"# {comment}"]
    lines += ["v " + _fixed(vertex, 5) for vertex in mesh.vertices]
    lines += ["vn " + _fixed(normal, 3) for normal in mesh.normals]
    lines += ["f " + " ".join(f"{i + 1}//{i + 1}" for i in face) for face in mesh.faces]
    return "\n".join(lines) + "\n"


def _fixed(vector: Array, digits: int) -> str:
    """Writes a vector with a fixed number of digits and no negative zero."""
    return " ".join(f"{value + 0.0:.{digits}f}" for value in np.round(vector, digits))
