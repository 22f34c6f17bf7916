"""Cones and wrenches of line contacts that only tests compare with."""

import numpy as np

from drake_linefoot.contact.wrench_cone import line_cone


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
