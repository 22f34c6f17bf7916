"""Friction cones of a line contact, (9)-(18), as rows ``W w <= 0``.

A line contact of half length X along the foot's x axis carries five numbers,
``w = [f_x, f_y, f_z, tau_y, tau_z]``, at the middle C of the line, here all in the foot
frame. A line cannot carry a moment about itself, so tau_x = 0, (13).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

WRENCH_SIZE = 5


def _check(mu: float, half_length: float = 1.0) -> None:
    """Refuse a friction coefficient or half length that is not positive."""
    if not (np.isfinite(mu) and mu > 0.0):
        raise ValueError(f"friction = {mu}: must be positive")
    if not (np.isfinite(half_length) and half_length > 0.0):
        raise ValueError(f"half length = {half_length}: must be positive")


def point_cone(mu: float) -> Array:
    """Return the linearised friction cone of one point contact, (9).

    Args:
        mu: friction coefficient [-].

    Returns:
        Rows of ``W [f_x, f_y, f_z] <= 0``, shape (4, 3); they imply 0 <= f_z.

    Raises:
        ValueError: `mu` is not positive.
    """
    _check(mu)
    return np.array([[1.0, 0.0, -mu], [-1.0, 0.0, -mu], [0.0, 1.0, -mu], [0.0, -1.0, -mu]])


def line_cone(mu: float, half_length: float) -> Array:
    """Return the simplified line-contact wrench cone, (18).

    Args:
        mu: friction coefficient [-].
        half_length: X, half the length of the contact line [m].

    Returns:
        Six rows of ``W w <= 0`` in w = [f_x, f_y, f_z, tau_y, tau_z], shape (6, 5).

    Raises:
        ValueError: `mu` or `half_length` is not positive.
    """
    _check(mu, half_length)
    X, b = half_length, mu * half_length
    return np.array(
        [
            [1.0, 0.0, -mu, 0.0, 0.0],
            [-1.0, 0.0, -mu, 0.0, 0.0],
            # tau_z <= mu X f_z - |X f_y + mu tau_y|
            [0.0, X, -b, mu, 1.0],
            [0.0, -X, -b, -mu, 1.0],
            # -tau_z <= mu X f_z - |X f_y - mu tau_y|
            [0.0, X, -b, -mu, -1.0],
            [0.0, -X, -b, mu, -1.0],
        ]
    )


def full_line_cone(mu: float, half_length: float) -> Array:
    """Return the line-contact wrench cone with its redundant rows, (10)-(12), (14), (15).

    Args:
        mu: friction coefficient [-].
        half_length: X, half the length of the contact line [m].

    Returns:
        Rows of ``W w <= 0`` in the five variables of `line_cone`, shape (11, 5).

    Raises:
        ValueError: `mu` or `half_length` is not positive.
    """
    X = half_length
    redundant = np.array(
        [
            [0.0, 1.0, -mu, 0.0, 0.0],  # (11)
            [0.0, -1.0, -mu, 0.0, 0.0],
            [0.0, 0.0, -1.0, 0.0, 0.0],  # (12)
            [0.0, 0.0, -X, 1.0, 0.0],  # (14)
            [0.0, 0.0, -X, -1.0, 0.0],
        ]
    )
    return np.vstack([line_cone(mu, half_length), redundant])


def wrench_from_points(f_heel: ArrayLike, f_toe: ArrayLike, half_length: float) -> Array:
    """Add two point forces at -X and +X to the wrench at the middle of the line.

    Args:
        f_heel: force at x = -X [N], shape (..., 3), foot frame.
        f_toe: force at x = +X [N], shape (..., 3), foot frame.
        half_length: X [m].

    Returns:
        [f_x, f_y, f_z, tau_y, tau_z] [N, N m], shape (..., 5).
    """
    f_heel = np.asarray(f_heel, dtype=float)
    f_toe = np.asarray(f_toe, dtype=float)
    difference = f_toe - f_heel
    # tau = x e_x cross f = x (0, -f_z, f_y)
    return np.concatenate(
        [
            f_heel + f_toe,
            -half_length * difference[..., 2:3],
            half_length * difference[..., 1:2],
        ],
        axis=-1,
    )


def points_from_wrench(wrench: ArrayLike, half_length: float, mu: float) -> tuple[Array, Array]:
    """Split a wrench into feasible point forces at heel and toe.

    The y and z components follow from the wrench. The two x forces only have to add up
    to f_x and are shared in proportion to the normal forces, which keeps both inside their
    cones whenever the wrench is inside (18).

    Args:
        wrench: [f_x, f_y, f_z, tau_y, tau_z] in the foot frame, shape (5,) [N, N m].
        half_length: X [m].
        mu: friction coefficient, only to refuse meaningless input [-].

    Returns:
        (f_heel, f_toe) [N], each of shape (3,).

    Raises:
        ValueError: `mu` or `half_length` is not positive.
    """
    _check(mu, half_length)
    f_x, f_y, f_z, tau_y, tau_z = np.asarray(wrench, dtype=float)
    z = 0.5 * np.array([f_z + tau_y / half_length, f_z - tau_y / half_length])
    y = 0.5 * np.array([f_y - tau_z / half_length, f_y + tau_z / half_length])
    x = f_x * (z / f_z if f_z != 0.0 else np.array([0.5, 0.5]))
    return np.array([x[0], y[0], z[0]]), np.array([x[1], y[1], z[1]])


def world_cone(mu: float, half_length: float, R_WF: Array) -> Array:
    """Return `line_cone` for forces in world and torques in foot coordinates, (36), (42).

    Args:
        mu: friction coefficient [-].
        half_length: X [m].
        R_WF: foot orientation in world, shape (3, 3).

    Returns:
        Rows of ``W u <= 0`` with u = [f_W, tau_y_F, tau_z_F], shape (6, 5).
    """
    W = line_cone(mu, half_length)
    return np.hstack([W[:, :3] @ np.asarray(R_WF).T, W[:, 3:]])
