"""Cones and wrenches of contacts that only tests compare with."""

import numpy as np
from scipy.optimize import linprog

from drake_linefoot.contact.surface import SurfaceContact, surface_cone
from drake_linefoot.contact.wrench_cone import line_cone, point_cone


def full_line_cone(mu, half_length):
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


def wrench_from_points(f_heel, f_toe, half_length):
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


def turned_cone(mu, half_length, R_WF):
    """Rows of (18) for forces in W and torques in the frame of the foot, shape (6, 5)."""
    W = line_cone(mu, half_length)
    return np.hstack([W[:, :3] @ R_WF.T, W[:, 3:]])


class ThinSurface(SurfaceContact):
    """A surface whose cone is that of no width: (18), and rows that hold tau_x at 0.

    Its torques keep the units of a rectangle, for those of its own would be 0.
    """

    def cone(self, mu):
        """Rows of ``W w <= 0``, shape (16, 6)."""
        return surface_cone(mu, self.half_length, 0.0) / self.half_length

    def scaled(self):
        """Return a contact whose cone is that of scaled wrenches."""
        return _ScaledThin(self.half_length, self.half_width)


class _ScaledThin(ThinSurface):
    def cone(self, mu):
        return super().cone(mu) * self.units(1.0 / 9.81)


def corner_excess(w, X, Y, mu):
    """By how much forces at four corners that make a wrench leave their pyramids at least [N].

    Args:
        w: [f_x, f_y, f_z, tau_y, tau_z, tau_x] in the frame of the ground, shape (6,).
        X: half the length [m].
        Y: half the width [m].
        mu: friction coefficient [-].
    """
    pyramids = np.kron(np.eye(4), point_cone(mu))
    A = np.hstack([pyramids, -np.ones((16, 1))])
    sums = np.hstack([grasp(X, Y), np.zeros((6, 1))])
    unknowns = {"A_eq": sums, "b_eq": w, "bounds": (None, None)}
    found = linprog(np.eye(13)[-1], A, np.zeros(16), **unknowns)
    assert found.status == 0
    return found.fun


def grasp(X, Y):
    """What forces at the four corners of a rectangle give, shape (6, 12)."""
    blocks = []
    for x in (-X, X):
        for y in (Y, -Y):
            tau = np.array([[0.0, 0.0, y], [0.0, 0.0, -x], [-y, x, 0.0]])  # p cross f, at z = 0
            blocks.append(np.vstack([np.eye(3), tau[[1, 2, 0]]]))
    return np.hstack(blocks)
