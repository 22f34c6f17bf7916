"""Friction cones of a line contact, (9)-(18), as rows ``W w <= 0``.

A line contact of half length X along the foot's x axis carries five numbers,
``w = [f_x, f_y, f_z, tau_y, tau_z]``, at the middle C of the line, here all in the foot
frame. A line cannot carry a moment about itself, so tau_x = 0, (13).
"""

import math

import numpy as np
from numpy.typing import ArrayLike

from drake_linefoot.axes import TAU_Y, TAU_Z
from drake_linefoot.math.compiled import as_python, compiled, inlined
from drake_linefoot.types import Array, Indices

HEEL, TOE, BOTH, NEITHER = 0, 1, 2, 3  # whose friction a row has; BOTH: the greater one
FRICTIONAL = (2, 3, 5)  # columns that friction multiplies: f_z and its moments tau_y, tau_x
LEVEL = np.zeros(2)  # slope of level ground


def check_positive(mu: float, half_length: float = 1.0, name: str = "half length") -> None:
    """Refuse a friction coefficient [-] or a half length [m] that is not positive.

    Raises:
        ValueError: one is not; `name` says which length.
    """
    if not (np.isfinite(mu) and mu > 0.0):
        raise ValueError(f"friction = {mu}: must be positive")
    if not (np.isfinite(half_length) and half_length > 0.0):
        raise ValueError(f"{name} = {half_length}: must be positive")


def point_cone(mu: float) -> Array:
    """Return the linearised friction cone of one point contact, (9).

    Args:
        mu: friction coefficient [-].

    Returns:
        Rows of ``W [f_x, f_y, f_z] <= 0``, shape (4, 3); they imply 0 <= f_z.

    Raises:
        ValueError: `mu` is not positive.
    """
    check_positive(mu)
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
    check_positive(mu, half_length)
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


def force_cone(mu: float, half_length: float) -> Array:
    """Return `line_cone` with every row of the unit of a force: rows of a torque over X, (6, 5).

    Raises:
        ValueError: `mu` or `half_length` is not positive.
    """
    cone = line_cone(mu, half_length)
    cone[2:] /= half_length
    return cone


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
    check_positive(mu, half_length)
    heel, toe = as_python(forces_at_ends)(np.asarray(wrench, dtype=float), half_length)
    return heel, toe


@compiled
def forces_at_ends(wrench: Array, half_length: float) -> Array:
    """Return the forces of `points_from_wrench`, heel over toe, shape (2, 3), unchecked."""
    forces = np.empty((2, 3))
    for i in range(2):
        end = 2.0 * i - 1.0
        forces[i, 2] = 0.5 * (wrench[2] - end * wrench[3] / half_length)
        forces[i, 1] = 0.5 * (wrench[1] + end * wrench[4] / half_length)
        loaded = wrench[2] != 0.0
        forces[i, 0] = wrench[0] * forces[i, 2] / wrench[2] if loaded else 0.5 * wrench[0]
    return forces


@inlined
def turn_across(R_WC: Array, slope: Array) -> tuple[float, float]:
    """Return cosine and sine of the turn about the line, from its frame C to the ground's.

    The line tells the slope along it, its frame has y level. Across the line the ground may
    rise as well, so its normal is turned against that of C.

    Args:
        R_WC: contact frame, shape (3, 3).
        slope: of the ground, rise per metre along x and y of the world, shape (2,).
    """
    # The normal (-s_x, -s_y, 1) in C; what it has along the line is the line's own affair.
    across = R_WC[2, 1] - slope[0] * R_WC[0, 1] - slope[1] * R_WC[1, 1]
    up = R_WC[2, 2] - slope[0] * R_WC[0, 2] - slope[1] * R_WC[1, 2]
    size = math.hypot(across, up)
    return up / size, -across / size


@compiled
def ground_frame(R_WC: Array, slope: Array) -> Array:
    """Return the frame of the ground under a line: C turned about the line, shape (3, 3).

    Args:
        R_WC: contact frame, shape (3, 3).
        slope: of the ground, rise per metre along x and y of the world, shape (2,).
    """
    c, s = turn_across(R_WC, slope)
    R = np.empty((3, 3))
    R[:, 0] = R_WC[:, 0]
    R[:, 1] = c * R_WC[:, 1] + s * R_WC[:, 2]
    R[:, 2] = c * R_WC[:, 2] - s * R_WC[:, 1]
    return R


@compiled
def with_friction(cone: Array, ends: Indices, shares: Array) -> Array:
    """Return a cone for shares of its friction at heel and toe, shape (r, c).

    The rows of an end say that its force to the side is within its friction. Of the force along
    a line only the sum is bounded, by the greater friction.

    Args:
        cone: rows, shape (r, c).
        ends: whose friction each has: `HEEL`, `TOE`, `BOTH` or `NEITHER`, shape (r,).
        shares: above 0, without which no row would keep the end from pulling, shape (2,).
    """
    less, (heel, toe) = cone.copy(), (shares[0], shares[1])
    share = (heel, toe, max(heel, toe), 1.0)
    for row in range(len(cone)):
        for column in FRICTIONAL:
            if column < cone.shape[1]:
                less[row, column] *= share[ends[row]]
    return less


@compiled
def world_cone(cone: Array, R_WC: Array, slope: Array) -> Array:
    """Return the rows of a cone for a wrench with forces in W and torques in C, (36), (42).

    ``[cone_f @ R_WS', cone_tau @ (R_WS' R_WC)]`` for the frame S of the ground, entry by entry:
    with `@` it takes ten times as long, which would be 3 % of a tick of the closed loop.

    Args:
        cone: rows in the frame of the ground, shape (n, c).
        R_WC: contact frame, shape (3, 3).
        slope: of the ground, rise per metre along x and y of the world, shape (2,).

    Returns:
        Shape (n, c).
    """
    c, s = turn_across(R_WC, slope)
    W = np.empty(cone.shape)
    for i in range(len(cone)):
        x = cone[i, 0]
        y, z = c * cone[i, 1] - s * cone[i, 2], s * cone[i, 1] + c * cone[i, 2]
        for j in range(3):
            W[i, j] = x * R_WC[j, 0] + y * R_WC[j, 1] + z * R_WC[j, 2]
        if cone.shape[1] > TAU_Z:
            W[i, TAU_Y] = c * cone[i, TAU_Y] - s * cone[i, TAU_Z]
            W[i, TAU_Z] = s * cone[i, TAU_Y] + c * cone[i, TAU_Z]
        for j in range(TAU_Z + 1, cone.shape[1]):
            W[i, j] = cone[i, j]  # about the axis that both frames have
    return W


@compiled
def world_cones(cone: Array, R_WC: Array, slopes: Array) -> Array:
    """Return `world_cone` of many contacts, of (n, 3, 3) and (n, 2), shape (n, r, c)."""
    W = np.empty((len(R_WC), *cone.shape))
    for k in range(len(R_WC)):
        W[k] = world_cone(cone, R_WC[k], slopes[k])
    return W
