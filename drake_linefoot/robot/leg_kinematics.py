"""Kinematics of contact lines for many configurations at once: where they are, and back.

Everything is expressed in the torso frame B, at its origin. Loops, not `@`: a product of small
matrices is a call of BLAS each, of which there would be thousands in an update of the MPC.
"""

import math

import numpy as np

from drake_linefoot.math.compiled import compiled, inlined
from drake_linefoot.math.linear import dot
from drake_linefoot.robot.chains import JOINTS
from drake_linefoot.robot.legs import Legs, Links, chain, new_links
from drake_linefoot.types import Array

STANDSTILL = 1e-3  # [-] of the residual: a step that changes it by less brings nothing
DAMPING = 1e-8  # [-] so that a straight knee gives a finite step
_BEHIND = 1e-9  # [-] sine below which a line that points backwards has no axis of its own


@compiled
def line(links: Links, end: Array, p: Array, J: Array) -> None:
    """Write the middle of the contact line and its Jacobian.

    Args:
        links: of the leg.
        end: middle of the line in the last frame [m], shape (3,).
        p: becomes the middle of the line [m], shape (3,).
        J: becomes the map from joint rates to its velocity and to the angular velocity of the
            foot, shape (6, 5).
    """
    a, o, foot = links.axes, links.origins, links.R[JOINTS]
    for r in range(3):
        out = foot[r, 0] * end[0] + foot[r, 1] * end[1] + foot[r, 2] * end[2]
        p[r] = o[JOINTS, r] + out
    for i in range(JOINTS):
        x, y, z = p[0] - o[i + 1, 0], p[1] - o[i + 1, 1], p[2] - o[i + 1, 2]
        J[0, i] = a[i, 1] * z - a[i, 2] * y
        J[1, i] = a[i, 2] * x - a[i, 0] * z
        J[2, i] = a[i, 0] * y - a[i, 1] * x
        for r in range(3):
            J[3 + r, i] = a[i, r]


@compiled
def line_rows(R: Array, linear: Array, angular: Array, out: Array) -> None:
    """Write a vector and the parts of another across the line: y and z of the foot.

    Args:
        R: orientation of the foot, shape (3, 3).
        linear: shape (3,).
        angular: shape (3,).
        out: shape (5,).
    """
    for r in range(3):
        out[r] = linear[r]
    for r in range(2):
        out[3 + r] = R[0, 1 + r] * angular[0] + R[1, 1 + r] * angular[1] + R[2, 1 + r] * angular[2]


@compiled
def line_jacobian(R: Array, J: Array, E: Array) -> None:
    """Write the rows of (51) in the torso frame.

    Args:
        R: orientation of the foot, shape (3, 3).
        J: of `line`, shape (6, 5).
        E: shape (5, 5).
    """
    for i in range(JOINTS):
        for r in range(3):
            E[r, i] = J[r, i]
        for r in range(2):
            E[3 + r, i] = R[0, 1 + r] * J[3, i] + R[1, 1 + r] * J[4, i] + R[2, 1 + r] * J[5, i]


@compiled
def line_turn(R: Array, d: Array, turn: Array) -> None:
    """Write the rotation that takes the line of a foot to `d`, of length sin below a right angle.

    Above, its length is the angle, since the sine would vanish again for a line that points
    backwards; one that points straight backwards turns about z.

    Args:
        R: orientation of the foot, the line along x, shape (3, 3).
        d: unit vector, shape (3,).
        turn: becomes the rotation vector, shape (3,).
    """
    x0, x1, x2 = R[0, 0], R[1, 0], R[2, 0]
    turn[0] = x1 * d[2] - x2 * d[1]
    turn[1] = x2 * d[0] - x0 * d[2]
    turn[2] = x0 * d[1] - x1 * d[0]
    cosine = x0 * d[0] + x1 * d[1] + x2 * d[2]
    if cosine < 0.0:
        sine = math.sqrt(turn[0] ** 2 + turn[1] ** 2 + turn[2] ** 2)
        if not sine > _BEHIND:
            turn[0], turn[1], turn[2] = R[0, 2], R[1, 2], R[2, 2]
        norm = math.sqrt(turn[0] ** 2 + turn[1] ** 2 + turn[2] ** 2)
        for r in range(3):
            turn[r] *= math.atan2(sine, cosine) / norm


@compiled
def damped_step(E: Array, error: Array, normal: Array, step: Array) -> None:
    """Write the solution of ``E step = error``, damped.

    Args:
        E: shape (5, 5).
        error: shape (5,).
        normal: memory, shape (5, 5).
        step: shape (5,).
    """
    for i in range(JOINTS):
        step[i] = 0.0
        for j in range(i + 1):
            normal[i, j] = DAMPING if i == j else 0.0
    for k in range(JOINTS):
        for i in range(JOINTS):
            step[i] += E[k, i] * error[k]
            for j in range(i + 1):
                normal[i, j] += E[k, i] * E[k, j]
    # Cholesky, in place: positive whatever E is, since it is damped.
    for i in range(JOINTS):
        for j in range(i + 1):
            s = normal[i, j]
            for k in range(j):
                s -= normal[i, k] * normal[j, k]
            normal[i, j] = math.sqrt(s) if i == j else s / normal[j, j]
        s = step[i]
        for k in range(i):
            s -= normal[i, k] * step[k]
        step[i] = s / normal[i, i]
    for i in range(JOINTS - 1, -1, -1):
        s = step[i]
        for k in range(i + 1, JOINTS):
            s -= normal[k, i] * step[k]
        step[i] = s / normal[i, i]


@compiled
def forward(legs: Legs, q: Array) -> tuple[Array, Array, Array]:
    """Return pose and Jacobian of contact lines in the torso frame.

    Args:
        legs: n legs.
        q: joint angles [rad], shape (n, K, 5).

    Returns:
        (p_BC, R_BF, J): shapes (n, K, 3), (n, K, 3, 3), (n, K, 6, 5); J maps joint rates to
        the velocity of C (first three) and the angular velocity of F, both in B.
    """
    n, K, _ = q.shape
    p, R_BF, J = np.empty((n, K, 3)), np.empty((n, K, 3, 3)), np.empty((n, K, 6, JOINTS))
    links = new_links()
    for leg in range(n):
        for k in range(K):
            chain(legs, leg, q[leg, k], links)
            line(links, legs.ends[leg], p[leg, k], J[leg, k])
            R_BF[leg, k] = links.R[JOINTS]
    return p, R_BF, J


@compiled
def inverse(
    legs: Legs,
    p_BC: Array,
    d_B: Array,
    guess: Array,
    iterations: int,
    tolerance: float,
) -> tuple[Array, Array]:
    """Return joint angles that place contact lines, by damped Newton.

    All lines step together, until none moves any more. A line out of reach gets the angles of the
    nearest one the iteration finds; the residual says how far away that is.

    Args:
        legs: n legs.
        p_BC: middles of the lines [m], shape (n, K, 3).
        d_B: their directions, unit vectors, shape (n, K, 3).
        guess: joint angles to start from [rad], shape (n, K, 5).
        iterations: most steps.
        tolerance: residual at which to stop [m, rad].

    Returns:
        (q, residual): shapes (n, K, 5) and (n, K), the best found.
    """
    n, K, _ = guess.shape
    links, p, turn, J = new_links(), np.empty(3), np.empty(3), np.empty((6, JOINTS))
    error, E, normal = np.empty(JOINTS), np.empty((JOINTS, JOINTS)), np.empty((JOINTS, JOINTS))
    q, steps, best = guess.copy(), np.zeros((n, K, JOINTS)), guess.copy()
    smallest, before = np.full((n, K), np.inf), np.full((n, K), np.inf)
    for number in range(iterations + 1):
        going_on = False
        for leg in range(n):
            for k in range(K):
                at = q[leg, k]
                for i in range(JOINTS):
                    moved = at[i] + steps[leg, k, i]
                    at[i] = min(max(moved, legs.lower[leg, i]), legs.upper[leg, i])
                chain(legs, leg, at, links)
                line(links, legs.ends[leg], p, J)
                foot = links.R[JOINTS]
                line_turn(foot, d_B[leg, k], turn)
                for i in range(3):
                    p[i] = p_BC[leg, k, i] - p[i]
                line_rows(foot, p, turn, error)
                residual = math.sqrt(dot(error, error))
                moving = abs(residual - before[leg, k]) > STANDSTILL * residual
                going_on |= residual >= tolerance and moving
                before[leg, k] = residual
                if residual < smallest[leg, k] or number == 0:
                    smallest[leg, k] = residual if residual < np.inf else np.inf
                    best[leg, k] = at
                line_jacobian(foot, J, E)
                damped_step(E, error, normal, steps[leg, k])
        if not going_on:
            break
    return best, smallest


@inlined
def rates(legs: Legs, q: Array, v_BC: Array, w_BF: Array) -> Array:
    """Return joint rates that move contact lines.

    Args:
        legs: n legs.
        q: joint angles [rad], shape (n, K, 5).
        v_BC: velocities of the middles [m/s], shape (n, K, 3).
        w_BF: angular velocities of the lines [rad/s], shape (n, K, 3); the part along a line
            does not count.

    Returns:
        Joint rates [rad/s], shape (n, K, 5).
    """
    n, K, _ = q.shape
    links, p, J = new_links(), np.empty(3), np.empty((6, JOINTS))
    right, E, normal = np.empty(JOINTS), np.empty((JOINTS, JOINTS)), np.empty((JOINTS, JOINTS))
    out = np.empty((n, K, JOINTS))
    for leg in range(n):
        for k in range(K):
            chain(legs, leg, q[leg, k], links)
            line(links, legs.ends[leg], p, J)
            line_jacobian(links.R[JOINTS], J, E)
            line_rows(links.R[JOINTS], v_BC[leg, k], w_BF[leg, k], right)
            damped_step(E, right, normal, out[leg, k])
    return out
