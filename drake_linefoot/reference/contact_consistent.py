"""Contact-consistent centroidal dynamics: how the torso turns over feet that move as planned.

A leg has five joints and its contact line five coordinates, so a torso that moves over planned
feet leaves the joints no choice. With P, the point of the torso where the CoM is, the foot i at
its place moves by ``K_i [w; v_P] + J_i qdot_i = u_i``. Put into the momenta, ::

    [L; m r'] = (diag(I_B, m 1) - sum G_i K_i) [w; v_P] + sum G_i u_i,    G_i = A_i J_i^-1
              =: A_c [w; v_P] + c,                     w = E ([L; m r'] - c)

where A_i are the momenta of the leg's joints. With locked joints, G = 0, it is (25). All in B.

The joint angles are those of the reference: how E and c change where the CoM is not there, or the
torso is tilted, is left out; docs/mathematics.md says how much that is.
"""

import numpy as np

from drake_linefoot.math.compiled import compiled, inlined
from drake_linefoot.math.linear import backward, cholesky, forward
from drake_linefoot.math.rotation import skews
from drake_linefoot.robot.chains import JOINTS
from drake_linefoot.robot.leg_inertia import MomentumMaps
from drake_linefoot.robot.leg_kinematics import line, line_jacobian, line_rows
from drake_linefoot.robot.legs import Legs, chain, new_links
from drake_linefoot.types import Array

NEAR_SINGULAR = 0.2  # [-] of the determinant in the nominal posture
DAMPING = 0.01  # [-] of the mean square of its singular values there


def determinant(legs: Legs, q: Array) -> float:
    """Return the least of the legs' Jacobian determinants at joint angles q [rad], (n, 5)."""
    links, p, J, E = new_links(), np.empty(3), np.empty((6, JOINTS)), np.empty((JOINTS, JOINTS))
    least = np.inf
    for leg in range(len(q)):
        chain(legs, leg, q[leg], links)
        line(links, legs.ends[leg], p, J)
        line_jacobian(links.R[JOINTS], J, E)
        root, _ = cholesky(E @ E.T)
        least = min(least, float(np.prod(np.diag(root))))
    return least


@inlined
def damped_inverse(E: Array, nominal: float) -> Array:
    """Return ``E^-1``; near a straight knee the damped one, which is bounded.

    The damping grows from zero as the determinant falls below a share of its nominal value
    (Nakamura and Hanafusa, 1986).

    Args:
        E: Jacobian of a contact line, shape (5, 5).
        nominal: its determinant in the nominal posture.

    Returns:
        Shape (5, 5).
    """
    normal = E @ E.T
    root, positive = cholesky(normal)
    share = np.prod(np.diag(root)) / (NEAR_SINGULAR * nominal) if positive else 0.0
    if share < 1.0:
        for i in range(JOINTS):
            normal[i, i] += DAMPING * nominal ** (2.0 / JOINTS) * (1.0 - share**2)
        root, _ = cholesky(normal)
    X = E.copy()
    forward(root, X)
    backward(root, X)
    return X.T


@compiled
def planned_lines(
    legs: Legs, q: Array, v: Array, w: Array, nominal: float
) -> tuple[Array, Array, Array, Array]:
    """Return where contact lines are at K times, what moves them, and how they should move.

    Args:
        legs: both legs.
        q: joint angles [rad], shape (2, K, 5).
        v: see `contact_maps`.
        w: see there.
        nominal: determinant of a leg's Jacobian in the nominal posture, see `determinant`.

    Returns:
        Middles [m] and orientations of the feet in B, J_i^-1 and u_i of the module; shapes
        (2, K, 3), (2, K, 3, 3), (2, K, 5, 5) and (2, K, 5).
    """
    n, K, _ = q.shape
    p, R, u = np.empty((n, K, 3)), np.empty((n, K, 3, 3)), np.empty((n, K, JOINTS))
    inverses = np.empty((n, K, JOINTS, JOINTS))
    links, J, E = new_links(), np.empty((6, JOINTS)), np.empty((JOINTS, JOINTS))
    for leg in range(n):
        for k in range(K):
            chain(legs, leg, q[leg, k], links)
            line(links, legs.ends[leg], p[leg, k], J)
            R[leg, k] = links.R[JOINTS]
            line_jacobian(R[leg, k], J, E)
            line_rows(R[leg, k], v[leg, k], w[leg, k], u[leg, k])
            inverses[leg, k] = damped_inverse(E, nominal)
    return p, R, inverses, u


def contact_maps(
    legs: Legs, q: Array, maps: MomentumMaps, v: Array, w: Array, m: float, nominal: float
) -> tuple[Array, Array]:
    """Return A_c and c at K times, see the module.

    Args:
        legs: both legs.
        q: joint angles [rad], shape (2, K, 5).
        maps: momenta of turning and of the joints at these angles.
        v: velocities of the lines' middles in W, with the axes of B [m/s], shape (2, K, 3).
        w: angular velocities, alike [rad/s]; the part along a line does not count.
        m: mass [kg].
        nominal: determinant of a leg's Jacobian in the nominal posture, see `determinant`.

    Returns:
        (A, c): shapes (K, 6, 6) and (K, 6), angular over linear, about the CoM, in B.
    """
    p, R, inverses, u = planned_lines(legs, q, v, w, nominal)
    rows = np.zeros((*u.shape, 6))  # K_i
    rows[..., :3, :3] = skews(maps.com - p)
    rows[..., :3, 3:] = np.eye(3)
    rows[..., 3:, :3] = R[..., 1:].swapaxes(2, 3)
    A = np.zeros((len(maps.com), 6, 6))
    A[:, :3, :3], A[:, 3:, 3:] = maps.I_B, m * np.eye(3)
    G = np.concatenate([maps.angular, maps.linear], axis=2) @ inverses
    left, right = G @ rows
    return A - left - right, np.matvec(G, u).sum(axis=0)


def torso_rates(A: Array) -> Array:
    """Return E, which takes [L; m r'] to the torso's angular velocity, shape (K, 3, 6).

    Args:
        A: A_c of `contact_maps`, shape (K, 6, 6).

    Raises:
        LinAlgError: A is singular.
    """
    return np.ascontiguousarray(np.linalg.inv(A)[:, :3])


def angular_momentum(A: Array, c: Array, Omega: Array, p: Array) -> Array:
    """Return the angular momentum of a torso that turns as planned over planned feet.

    Args:
        A: A_c of `contact_maps`, shape (K, 6, 6).
        c: of it, shape (K, 6).
        Omega: angular velocity of the torso in B [rad/s], shape (K, 3).
        p: linear momentum in B [kg m/s], shape (K, 3).

    Returns:
        About the CoM, in B [kg m^2/s], shape (K, 3).
    """
    turning = np.matvec(A[:, :, :3], Omega) + c
    v_P = np.linalg.solve(A[:, 3:, 3:], (p - turning[:, 3:])[..., None])
    return turning[:, :3] + np.matvec(A[:, :3, 3:], v_P[..., 0])
