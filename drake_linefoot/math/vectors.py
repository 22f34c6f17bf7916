"""Vectors of three numbers as tuples, for what runs over many bodies in one compiled function.

They stay in registers; an array of three costs more to allocate than to compute with.
"""

from drake_linefoot.math.compiled import compiled
from drake_linefoot.types import Array

Vector = tuple[float, float, float]


@compiled
def vector(rows: Array, i: int, j: int) -> Vector:
    """Return three numbers of row `i`, from column `j` on."""
    return rows[i, j], rows[i, j + 1], rows[i, j + 2]


@compiled
def write(rows: Array, i: int, j: int, a: Vector) -> None:
    """Write a vector to row `i`, from column `j` on."""
    rows[i, j], rows[i, j + 1], rows[i, j + 2] = a


@compiled
def plus(a: Vector, b: Vector) -> Vector:
    """Return the sum."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@compiled
def times(s: float, a: Vector) -> Vector:
    """Return the product with a number."""
    return s * a[0], s * a[1], s * a[2]


@compiled
def inner(a: Vector, b: Vector) -> float:
    """Return the inner product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled
def crossed(a: Vector, b: Vector) -> Vector:
    """Return the cross product."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


@compiled
def turned(R: Array, i: int, a: Vector) -> Vector:
    """Return ``R[i] a``, with rotations R, shape (n, 3, 3) or, with more columns, (n, 3, 4)."""
    return (
        R[i, 0, 0] * a[0] + R[i, 0, 1] * a[1] + R[i, 0, 2] * a[2],
        R[i, 1, 0] * a[0] + R[i, 1, 1] * a[1] + R[i, 1, 2] * a[2],
        R[i, 2, 0] * a[0] + R[i, 2, 1] * a[1] + R[i, 2, 2] * a[2],
    )


@compiled
def turned_back(R: Array, i: int, a: Vector) -> Vector:
    """Return ``R[i]' a``, with rotations R, shape (n, 3, 3) or, with more columns, (n, 3, 4)."""
    return (
        R[i, 0, 0] * a[0] + R[i, 1, 0] * a[1] + R[i, 2, 0] * a[2],
        R[i, 0, 1] * a[0] + R[i, 1, 1] * a[1] + R[i, 2, 1] * a[2],
        R[i, 0, 2] * a[0] + R[i, 1, 2] * a[1] + R[i, 2, 2] * a[2],
    )


@compiled
def column(R: Array, i: int, j: int) -> Vector:
    """Return column `j` of ``R[i]``, with R of shape (n, 3, 3) or (n, 3, 4)."""
    return R[i, 0, j], R[i, 1, j], R[i, 2, j]


@compiled
def write_column(R: Array, i: int, j: int, a: Vector) -> None:
    """Write column `j` of ``R[i]``."""
    R[i, 0, j], R[i, 1, j], R[i, 2, j] = a
