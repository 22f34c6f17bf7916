"""Compiled kinematics of legs and what their links weigh, one configuration after the other.

A leg is a chain of five revolute joints from the torso to a contact line. A joint's rotation by q
is ``turn = B0 + sin q B1 + (1 - cos q) B2``; beside it stand its axis and its place, both
constant in the frame before. Everything is expressed in the torso frame B, at its origin.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.math import kernels
from drake_linefoot.math.compiled import compiled

Array = NDArray[np.float64]

JOINTS = 5  # of a leg: as many as the line has coordinates
STANDSTILL = 1e-3  # [-] of the residual: a step that changes it by less brings nothing
DAMPING = 1e-8  # [-] so that a straight knee gives a finite step
_BEHIND = 1e-9  # [-] sine below which a line that points backwards has no axis of its own


class Legs(NamedTuple):
    """What a chain is made of, for n legs.

    Attributes:
        turns: B0, B1, B2 of each joint, shape (n, 3, 5, 3, 3).
        axes: of each joint in the frame before, unit vectors, shape (n, 5, 3).
        places: of each joint in the frame before [m], shape (n, 5, 3).
        ends: middle of the contact line in the last frame [m], shape (n, 3).
        lower: joint limits [rad], shape (n, 5).
        upper: joint limits [rad], shape (n, 5).
    """

    turns: Array
    axes: Array
    places: Array
    ends: Array
    lower: Array
    upper: Array


class Links(NamedTuple):
    """The five links of one leg in the torso frame.

    Attributes:
        R: orientations, shape (5, 3, 3).
        axes: of the joints that carry them, shape (5, 3).
        origins: [m], shape (5, 3).
    """

    R: Array
    axes: Array
    origins: Array


@compiled
def new_links() -> Links:
    """Return memory for the links of a leg."""
    return Links(np.empty((JOINTS, 3, 3)), np.empty((JOINTS, 3)), np.empty((JOINTS, 3)))


@compiled
def chain(legs: Legs, leg: int, q: Array, links: Links) -> None:
    """Write the links of a leg at joint angles `q` [rad], shape (5,)."""
    turns, axes, places = legs.turns[leg], legs.axes[leg], legs.places[leg]
    R, a, o = links.R, links.axes, links.origins
    turn, before = np.empty((3, 3)), np.eye(3)
    for i in range(JOINTS):
        sine, versine = math.sin(q[i]), 1.0 - math.cos(q[i])
        for r in range(3):
            for c in range(3):
                turned = sine * turns[1, i, r, c] + versine * turns[2, i, r, c]
                turn[r, c] = turns[0, i, r, c] + turned
                if i > 0:
                    before[r, c] = R[i - 1, r, c]
        for r in range(3):
            x, y, z = before[r, 0], before[r, 1], before[r, 2]
            for c in range(3):
                R[i, r, c] = x * turn[0, c] + y * turn[1, c] + z * turn[2, c]
            a[i, r] = x * axes[i, 0] + y * axes[i, 1] + z * axes[i, 2]
            o[i, r] = x * places[i, 0] + y * places[i, 1] + z * places[i, 2]
            if i > 0:
                o[i, r] += o[i - 1, r]


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
    a, o, foot = links.axes, links.origins, links.R[JOINTS - 1]
    for r in range(3):
        out = foot[r, 0] * end[0] + foot[r, 1] * end[1] + foot[r, 2] * end[2]
        p[r] = o[JOINTS - 1, r] + out
    for i in range(JOINTS):
        x, y, z = p[0] - o[i, 0], p[1] - o[i, 1], p[2] - o[i, 2]
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
        linear: shape (3, ...).
        angular: shape (3, ...).
        out: shape (5, ...).
    """
    for r in range(3):
        out[r] = linear[r]
    for r in range(2):
        out[3 + r] = R[0, 1 + r] * angular[0] + R[1, 1 + r] * angular[1] + R[2, 1 + r] * angular[2]


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
            turn[:] = R[:, 2]
        norm = math.sqrt(turn[0] ** 2 + turn[1] ** 2 + turn[2] ** 2)
        turn *= math.atan2(sine, cosine) / norm


@compiled
def damped_step(E: Array, error: Array, step: Array) -> None:
    """Write the solution of ``E step = error``, damped.

    Args:
        E: shape (5, 5).
        error: shape (5,).
        step: shape (5,).
    """
    n = len(error)
    normal, right = np.empty((n, n)), np.empty((n, 1))
    for i in range(n):
        for j in range(i + 1):
            s = 0.0
            for k in range(n):
                s += E[k, i] * E[k, j]
            normal[i, j] = s
        normal[i, i] += DAMPING
        s = 0.0
        for k in range(n):
            s += E[k, i] * error[k]
        right[i, 0] = s
    L, _ = kernels.cholesky(normal)
    kernels.forward(L, right)
    kernels.backward(L, right)
    step[:] = right[:, 0]


@compiled
def forward(legs: Legs, q: Array) -> tuple[Array, Array, Array]:
    """Return pose and Jacobian of contact lines in the torso frame.

    Args:
        legs: n legs.
        q: joint angles [rad], shape (n, K, 5).

    Returns:
        (p_BC, R_BF, J): shapes (n, K, 3), (n, K, 3, 3), (n, K, 6, 5).
    """
    n, K, _ = q.shape
    p, R_BF, J = np.empty((n, K, 3)), np.empty((n, K, 3, 3)), np.empty((n, K, 6, JOINTS))
    links = new_links()
    for leg in range(n):
        for k in range(K):
            chain(legs, leg, q[leg, k], links)
            line(links, legs.ends[leg], p[leg, k], J[leg, k])
            R_BF[leg, k] = links.R[JOINTS - 1]
    return p, R_BF, J


@compiled
def inverse(
    legs: Legs, p_BC: Array, d_B: Array, guess: Array, iterations: int, tolerance: float
) -> tuple[Array, Array]:
    """Return joint angles that place contact lines, by damped Newton.

    All lines step together, until none moves any more.

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
    error, E = np.empty(JOINTS), np.empty((JOINTS, JOINTS))
    q, steps, best = np.empty((n, K, JOINTS)), np.zeros((n, K, JOINTS)), guess.copy()
    q[:] = guess
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
                foot = links.R[JOINTS - 1]
                line_turn(foot, d_B[leg, k], turn)
                line_rows(foot, p_BC[leg, k] - p, turn, error)
                residual = math.sqrt(np.sum(error * error))
                moving = abs(residual - before[leg, k]) > STANDSTILL * residual
                going_on |= residual >= tolerance and moving
                before[leg, k] = residual
                if residual < smallest[leg, k] or number == 0:
                    smallest[leg, k] = residual if residual < np.inf else np.inf
                    best[leg, k] = at
                line_rows(foot, J[:3], J[3:], E)
                damped_step(E, error, steps[leg, k])
        if not going_on:
            break
    return best, smallest


@compiled
def rates(legs: Legs, q: Array, v_BC: Array, w_BF: Array) -> Array:
    """Return joint rates that move contact lines.

    Args:
        legs: n legs.
        q: joint angles [rad], shape (n, K, 5).
        v_BC: velocities of the middles [m/s], shape (n, K, 3).
        w_BF: angular velocities of the lines [rad/s], shape (n, K, 3).

    Returns:
        Joint rates [rad/s], shape (n, K, 5).
    """
    n, K, _ = q.shape
    links, p, J = new_links(), np.empty(3), np.empty((6, JOINTS))
    right, E = np.empty(JOINTS), np.empty((JOINTS, JOINTS))
    out = np.empty((n, K, JOINTS))
    for leg in range(n):
        for k in range(K):
            chain(legs, leg, q[leg, k], links)
            line(links, legs.ends[leg], p, J)
            line_rows(links.R[JOINTS - 1], J[:3], J[3:], E)
            line_rows(links.R[JOINTS - 1], v_BC[leg, k], w_BF[leg, k], right)
            damped_step(E, right, out[leg, k])
    return out
