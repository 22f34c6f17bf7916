"""Kinematics of contacts for many configurations at once: where they are, and back.

Everything is expressed in the torso frame B, at its origin. Loops, not `@`: a product of small
matrices is a call of BLAS each, of which there would be thousands in an update of the MPC.
"""

import math

import numpy as np

from drake_linefoot.axes import TORQUE_AXES
from drake_linefoot.axes import WRENCH as SURFACE
from drake_linefoot.math.compiled import compiled, inlined
from drake_linefoot.math.linear import dot
from drake_linefoot.math.rotation import log
from drake_linefoot.robot.legs import Legs, Links, chain, new_links
from drake_linefoot.types import Array

STANDSTILL = 1e-3  # [-] of the residual: a step that changes it by less brings nothing
DAMPING = 1e-8  # [-] so that a straight knee gives a finite step
_BEHIND = 1e-9  # [-] sine below which a line that points backwards has no axis of its own


@compiled
def contact_point(legs: Legs, leg: int, links: Links, p: Array, J: Array) -> None:
    """Write the middle of the contact of a leg and its Jacobian.

    Args:
        legs: of j joints each.
        leg: which of them.
        links: of that leg.
        p: becomes the middle of the contact [m], shape (3,).
        J: becomes the map from joint rates to its velocity and to the angular velocity of the
            foot, shape (6, j).
    """
    n, end = len(legs.zeros), legs.ends[leg]
    a, o, foot = links.axes, links.origins, links.R[n]
    for r in range(3):
        out = foot[r, 0] * end[0] + foot[r, 1] * end[1] + foot[r, 2] * end[2]
        p[r] = o[n, r] + out
    for i in range(n):
        x, y, z = p[0] - o[i + 1, 0], p[1] - o[i + 1, 1], p[2] - o[i + 1, 2]
        J[0, i] = a[i, 1] * z - a[i, 2] * y
        J[1, i] = a[i, 2] * x - a[i, 0] * z
        J[2, i] = a[i, 0] * y - a[i, 1] * x
        for r in range(3):
            J[3 + r, i] = a[i, r]


@compiled
def contact_rows(
    zeros: tuple[float, ...], R: Array, linear: Array, angular: Array, out: Array
) -> None:
    """Write a vector and parts of another in the foot: along y, z and, for a sole, x.

    Args:
        zeros: of `Legs`: as many as a contact has coordinates.
        R: orientation of the foot, shape (3, 3).
        linear: shape (3,).
        angular: shape (3,).
        out: shape (j,).
    """
    for r in range(3):
        out[r] = linear[r]
    for r in range(3, len(zeros)):
        c = TORQUE_AXES[r - 3]
        out[r] = R[0, c] * angular[0] + R[1, c] * angular[1] + R[2, c] * angular[2]


@compiled
def contact_jacobian(zeros: tuple[float, ...], R: Array, J: Array, E: Array) -> None:
    """Write the rows of (51) in the torso frame.

    Args:
        zeros: of `Legs`: as many as a contact has coordinates, and a leg joints.
        R: orientation of the foot, shape (3, 3).
        J: of `contact_point`, shape (6, j).
        E: shape (j, j).
    """
    for i in range(len(zeros)):
        for r in range(3):
            E[r, i] = J[r, i]
        for r in range(3, len(zeros)):
            c = TORQUE_AXES[r - 3]
            E[r, i] = R[0, c] * J[3, i] + R[1, c] * J[4, i] + R[2, c] * J[5, i]


def leg_jacobian(legs: Legs, leg: int, q: Array) -> Array:
    """Return the rows of (51) of a leg at its joint angles, see `contact_jacobian`.

    Args:
        legs: of j joints each.
        leg: which of them.
        q: [rad], shape (j,).

    Returns:
        Shape (j, j).
    """
    j = len(legs.zeros)
    links, p, J, E = new_links(legs), np.empty(3), np.empty((6, j)), np.empty((j, j))
    chain(legs, leg, q, links)
    contact_point(legs, leg, links, p, J)
    contact_jacobian(legs.zeros, links.R[j], J, E)
    return E


@compiled
def contact_turn(zeros: tuple[float, ...], R: Array, wanted: Array, turn: Array) -> None:
    """Write the rotation that takes the axes of a foot to others, of a line its x axis alone.

    That of a line has the length sin below a right angle. Above, its length is the angle, since
    the sine would vanish again for one that points backwards; straight backwards it is about z.

    Args:
        zeros: of `Legs`: as many as a contact has coordinates.
        R: orientation of the foot, shape (3, 3).
        wanted: orientation, shape (3, 3).
        turn: becomes the rotation vector, shape (3,).
    """
    if len(zeros) == len(SURFACE):
        error = np.zeros((3, 3))
        for r in range(3):
            for c in range(3):
                for k in range(3):
                    error[r, c] += wanted[r, k] * R[c, k]
        turn[:] = log(error)
        return
    x0, x1, x2 = R[0, 0], R[1, 0], R[2, 0]
    d0, d1, d2 = wanted[0, 0], wanted[1, 0], wanted[2, 0]
    turn[0] = x1 * d2 - x2 * d1
    turn[1] = x2 * d0 - x0 * d2
    turn[2] = x0 * d1 - x1 * d0
    cosine = x0 * d0 + x1 * d1 + x2 * d2
    if cosine < 0.0:
        sine = math.sqrt(turn[0] ** 2 + turn[1] ** 2 + turn[2] ** 2)
        if not sine > _BEHIND:
            turn[0], turn[1], turn[2] = R[0, 2], R[1, 2], R[2, 2]
        norm = math.sqrt(turn[0] ** 2 + turn[1] ** 2 + turn[2] ** 2)
        for r in range(3):
            turn[r] *= math.atan2(sine, cosine) / norm


@compiled
def damped_step(
    zeros: tuple[float, ...], E: Array, error: Array, normal: Array, step: Array
) -> None:
    """Write the solution of ``E step = error``, damped.

    Args:
        zeros: of `Legs`: as many as a leg has joints.
        E: shape (j, j).
        error: shape (j,).
        normal: memory, shape (j, j).
        step: shape (j,).
    """
    n = len(zeros)
    for i in range(n):
        step[i] = 0.0
        for j in range(i + 1):
            normal[i, j] = DAMPING if i == j else 0.0
    for k in range(n):
        for i in range(n):
            step[i] += E[k, i] * error[k]
            for j in range(i + 1):
                normal[i, j] += E[k, i] * E[k, j]
    # Cholesky, in place: positive whatever E is, since it is damped.
    for i in range(n):
        for j in range(i + 1):
            s = normal[i, j]
            for k in range(j):
                s -= normal[i, k] * normal[j, k]
            normal[i, j] = math.sqrt(s) if i == j else s / normal[j, j]
        s = step[i]
        for k in range(i):
            s -= normal[i, k] * step[k]
        step[i] = s / normal[i, i]
    for i in range(n - 1, -1, -1):
        s = step[i]
        for k in range(i + 1, n):
            s -= normal[k, i] * step[k]
        step[i] = s / normal[i, i]


@compiled
def forward(legs: Legs, q: Array) -> tuple[Array, Array, Array]:
    """Return pose and Jacobian of contacts in the torso frame.

    Args:
        legs: n legs of j joints.
        q: joint angles [rad], shape (n, K, j).

    Returns:
        (p_BC, R_BF, J): shapes (n, K, 3), (n, K, 3, 3), (n, K, 6, j); J maps joint rates to
        the velocity of C (first three) and the angular velocity of F, both in B.
    """
    n, K, j = q.shape
    p, R_BF, J = np.empty((n, K, 3)), np.empty((n, K, 3, 3)), np.empty((n, K, 6, j))
    links = new_links(legs)
    for leg in range(n):
        for k in range(K):
            chain(legs, leg, q[leg, k], links)
            contact_point(legs, leg, links, p[leg, k], J[leg, k])
            R_BF[leg, k] = links.R[j]
    return p, R_BF, J


@compiled
def inverse(
    legs: Legs,
    p_BC: Array,
    R_BF: Array,
    guess: Array,
    iterations: int,
    tolerance: float,
) -> tuple[Array, Array]:
    """Return joint angles that place contacts, by damped Newton.

    All step together, until none moves any more. One out of reach gets the angles of the nearest
    one the iteration finds; the residual says how far away that is.

    Args:
        legs: n legs of j joints.
        p_BC: middles of the contacts [m], shape (n, K, 3).
        R_BF: orientations of the feet, shape (n, K, 3, 3); of those with a line the x axis counts.
        guess: joint angles to start from [rad], shape (n, K, j).
        iterations: most steps.
        tolerance: residual at which to stop [m, rad].

    Returns:
        (q, residual): shapes (n, K, j) and (n, K), the best found.
    """
    (n, K, _), zeros, j = guess.shape, legs.zeros, len(legs.zeros)
    links, p, turn, J = new_links(legs), np.empty(3), np.empty(3), np.empty((6, j))
    error, E, normal = np.empty(j), np.empty((j, j)), np.empty((j, j))
    q, steps, best = guess.copy(), np.zeros((n, K, j)), guess.copy()
    smallest, before = np.full((n, K), np.inf), np.full((n, K), np.inf)
    for number in range(iterations + 1):
        going_on = False
        for leg in range(n):
            for k in range(K):
                at = q[leg, k]
                for i in range(j):
                    moved = at[i] + steps[leg, k, i]
                    at[i] = min(max(moved, legs.lower[leg, i]), legs.upper[leg, i])
                chain(legs, leg, at, links)
                contact_point(legs, leg, links, p, J)
                foot = links.R[j]
                contact_turn(zeros, foot, R_BF[leg, k], turn)
                for i in range(3):
                    p[i] = p_BC[leg, k, i] - p[i]
                contact_rows(zeros, foot, p, turn, error)
                residual = math.sqrt(dot(error, error))
                moving = abs(residual - before[leg, k]) > STANDSTILL * residual
                going_on |= residual >= tolerance and moving
                before[leg, k] = residual
                if residual < smallest[leg, k] or number == 0:
                    smallest[leg, k] = residual if residual < np.inf else np.inf
                    best[leg, k] = at
                contact_jacobian(zeros, foot, J, E)
                damped_step(zeros, E, error, normal, steps[leg, k])
        if not going_on:
            break
    return best, smallest


@inlined
def rates(legs: Legs, q: Array, v_BC: Array, w_BF: Array) -> Array:
    """Return joint rates that move contacts.

    Args:
        legs: n legs of j joints.
        q: joint angles [rad], shape (n, K, j).
        v_BC: velocities of the middles [m/s], shape (n, K, 3).
        w_BF: angular velocities of the feet [rad/s], shape (n, K, 3); the part along a line
            does not count.

    Returns:
        Joint rates [rad/s], shape (n, K, j).
    """
    (n, K, _), zeros, j = q.shape, legs.zeros, len(legs.zeros)
    links, p, J = new_links(legs), np.empty(3), np.empty((6, j))
    right, E, normal = np.empty(j), np.empty((j, j)), np.empty((j, j))
    out = np.empty((n, K, j))
    for leg in range(n):
        for k in range(K):
            chain(legs, leg, q[leg, k], links)
            contact_point(legs, leg, links, p, J)
            contact_jacobian(zeros, links.R[j], J, E)
            contact_rows(zeros, links.R[j], v_BC[leg, k], w_BF[leg, k], right)
            damped_step(zeros, E, right, normal, out[leg, k])
    return out
