"""The contact points of a foot, as they are recorded: two of a line, four of a sole.

They are heel and toe of a line; of a sole the corners, heel before toe and left before right.
"""

import numpy as np

from drake_linefoot.math.compiled import as_python
from drake_linefoot.robot.dynamics import contact_frame
from drake_linefoot.types import Array

OUTLINES = {2: (0, 1), 4: (0, 1, 3, 2, 0)}  # round a foot, by the number of its points
_SIDES = np.array([1.0, -1.0])  # left, right


def ends_of(points: Array) -> Array:
    """Return heel and toe of the line along the middle of feet [m], shape (..., 2, 3).

    Args:
        points: of each [m], shape (..., nc, 3).
    """
    *many, count, size = points.shape
    middles: Array = points.reshape(*many, 2, count // 2, size).mean(axis=-2)
    return middles


def centre_of_pressure(normal: Array) -> Array:
    """Return where forces on the points of feet act, in halves of its length and its width [-].

    Args:
        normal: on each point [N], shape (..., nc).

    Returns:
        -1 at the heel to 1 at the toe, -1 at the right to 1 at the left edge (0 on a line), shape
        (..., 2); NaN without a load.
    """
    ends = normal.reshape(*normal.shape[:-1], 2, normal.shape[-1] // 2)
    ahead = ends[..., 1, :].sum(axis=-1) - ends[..., 0, :].sum(axis=-1)
    left = (ends * (_SIDES if ends.shape[-1] > 1 else 0.0)).sum(axis=(-2, -1))
    load = normal.sum(axis=-1, keepdims=True)
    return np.stack([ahead, left], axis=-1) / np.where(load > 0.0, load, np.nan)


def place_in(points: Array, at: Array) -> Array:
    """Return a place in a foot that is given in halves of its length and its width [m], (3,).

    Args:
        points: of the foot [m], shape (nc, 3).
        at: see `centre_of_pressure`, shape (2,).
    """
    heel, toe = ends_of(points)
    place: Array = 0.5 * (heel + toe + at[0] * (toe - heel) + at[1] * (points[0] - points[1]))
    return place


def sole_frame(points: Array) -> Array:
    """Return the frame C of a foot: of a line with y level, of a sole with its axes, shape (3, 3).

    Args:
        points: [m], shape (nc, 3).
    """
    heel, toe = ends_of(points)
    x = (toe - heel) / np.linalg.norm(toe - heel)
    if len(points) == 2:
        # In Python: compiled for an array of this layout it would delay a first replay by 3 s.
        return as_python(contact_frame)(np.outer(x, [1.0, 0.0, 0.0]))
    z = np.cross(x, points[0] - points[1])
    z /= np.linalg.norm(z)
    return np.column_stack([x, np.cross(z, x), z])


def forces_at_points(wrench: Array, points: Array) -> Array:
    """Split the wrench on a foot into forces at its points that add up to it.

    The normal force is shared as the centre of pressure says, first between heel and toe, then
    between left and right; so is the force along the foot. What of the torque about the normal
    is left then, forces around C make; those of a line are the ones of `points_from_wrench`.

    Args:
        wrench: [f in W, tau_y, tau_z and, of a sole, tau_x in C] [N, N m], shape (nw,).
        points: [m], shape (nc, 3).

    Returns:
        Forces in W [N], shape (nc, 3); zero without a normal force.
    """
    R, middle = sole_frame(points), points.mean(axis=0)
    at = (points - middle) @ R  # in C
    f, (tau_y, tau_z, tau_x) = R.T @ wrench[:3], np.append(wrench[3:], 0.0)[:3]
    if f[2] == 0.0:
        return np.zeros(points.shape)
    across = np.abs(at[:, 1]).max()
    share = 0.5 - 0.5 * np.sign(at[:, 0]) * tau_y / (f[2] * np.abs(at[:, 0]).max())
    if len(points) > 2:
        share *= 0.5 + 0.5 * np.sign(at[:, 1]) * tau_x / (f[2] * across)
    forces = share[:, None] * f
    # Shares of a force to the side act where the pressure does; about C they turn the foot.
    rest = tau_z - float((at[:, 0] * forces[:, 1] - at[:, 1] * forces[:, 0]).sum())
    around = np.column_stack([-at[:, 1], at[:, 0], np.zeros(len(at))])
    forces += rest / (around**2).sum() * around
    result: Array = forces @ R.T
    return result


def hull_of(points: Array) -> Array:
    """Return the corners of the convex hull of points seen from above, in order, shape (m,).

    Args:
        points: [m], shape (n, 2) or wider; n at least 1.

    Returns:
        Which of them; two when they lie on a line.
    """
    order = np.lexsort((points[:, 1], points[:, 0])).tolist()
    corners: list[int] = []
    for way in (order, order[::-1]):  # below, then above
        chain: list[int] = []
        for i in way:
            while len(chain) > 1 and not _turns_left(*points[[*chain[-2:], i], :2]):
                chain.pop()
            chain.append(i)
        corners += chain[:-1]
    return np.array(corners or order[:1], dtype=int)


def _turns_left(a: Array, b: Array, c: Array) -> bool:
    """Return whether the way from a over b to c turns to the left."""
    (ux, uy), (vx, vy) = b - a, c - b
    return bool(ux * vy - uy * vx > 1e-12)
