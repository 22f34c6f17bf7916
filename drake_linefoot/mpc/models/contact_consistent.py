"""The model "contact_consistent": how the torso turns over feet that move as planned.

A leg has as many joints as its contact has coordinates, so a torso that moves over planned
feet leaves the joints no choice. With P, the point of the torso where the CoM is, the foot i at
its place moves by ``K_i [w; v_P] + J_i qdot_i = u_i``. Put into the momenta, ::

    [L; m r'] = (diag(I_B, m 1) - sum G_i K_i) [w; v_P] + sum G_i u_i,    G_i = A_i J_i^-1
              =: A_c [w; v_P] + c,                     w = E ([L; m r'] - c)

where A_i are the momenta of the leg's joints. With locked joints, G = 0, it is (25). All in B.

The joint angles are those of the reference: how E and c change where the CoM is not there, or the
torso is tilted, is left out; docs/mathematics.md says how much that is.
"""

import numpy as np

from drake_linefoot.axes import TORQUE_AXES
from drake_linefoot.centroidal import TIME_EPSILON
from drake_linefoot.errors import InputError
from drake_linefoot.gait.schedule import knots
from drake_linefoot.math.compiled import compiled, inlined
from drake_linefoot.math.discretisation import times, times_vector
from drake_linefoot.math.linear import backward, cholesky, copy, dot, eliminate, forward
from drake_linefoot.math.vectors import times as scaled
from drake_linefoot.math.vectors import turned_back, vector, write
from drake_linefoot.mpc.ecd import Linearisation
from drake_linefoot.mpc.models.ecd import planned_legs
from drake_linefoot.mpc.models.model import Model
from drake_linefoot.mpc.models.motion import (
    LinePlan,
    Robot,
    arm_momentum,
    middles,
    rates_in_torso,
    write_momentum,
)
from drake_linefoot.mpc.models.reaching import reaching_legs
from drake_linefoot.robot.leg_inertia import MomentumMaps
from drake_linefoot.robot.leg_kinematics import contact_jacobian, contact_point, contact_rows
from drake_linefoot.robot.legs import Legs, chain, new_links
from drake_linefoot.signals import GaitHorizon, Reference, open_dynamics, open_reference
from drake_linefoot.types import Array

NEAR_SINGULAR = 0.2  # [-] of the determinant in the nominal posture
DAMPING = 0.01  # [-] of the mean square of its singular values there


@inlined
def damped_inverse(zeros: tuple[float, ...], E: Array, nominal: float) -> Array:
    """Return ``E^-1``; near a straight knee the damped one, which is bounded.

    The damping grows from zero as the determinant falls below a share of its nominal value
    (Nakamura and Hanafusa, 1986).

    Args:
        zeros: of `Legs`: as many as a leg has joints.
        E: Jacobian of a contact, shape (j, j).
        nominal: its determinant in the nominal posture.

    Returns:
        Shape (j, j).
    """
    n = len(zeros)
    normal = np.empty((n, n))
    for i in range(n):
        for j in range(n):
            normal[i, j] = dot(E[i], E[j])
    root, positive = cholesky(normal)
    share = 1.0 / (NEAR_SINGULAR * nominal) if positive else 0.0
    for i in range(n):
        share *= root[i, i]
    if share < 1.0:
        for i in range(n):
            normal[i, i] += DAMPING * nominal ** (2.0 / n) * (1.0 - share**2)
        root, _ = cholesky(normal)
    X = E.copy()
    forward(root, X)
    backward(root, X)
    return X.T


@inlined
def planned_lines(
    legs: Legs, q: Array, v: Array, w: Array, nominal: float
) -> tuple[Array, Array, Array, Array]:
    """Return where contact lines are at K times, what moves them, and how they should move.

    Args:
        legs: both legs.
        q: joint angles [rad], shape (2, K, j).
        v: see `contact_maps`.
        w: see there.
        nominal: determinant of a leg's Jacobian in the nominal posture, see `determinant`.

    Returns:
        Middles [m] and orientations of the feet in B, J_i^-1 and u_i of the module; shapes
        (2, K, 3), (2, K, 3, 3), (2, K, j, j) and (2, K, j).
    """
    (n, K, _), zeros, size = q.shape, legs.zeros, len(legs.zeros)
    p, R, u = np.empty((n, K, 3)), np.empty((n, K, 3, 3)), np.empty((n, K, size))
    inverses = np.empty((n, K, size, size))
    links, J, E = new_links(legs), np.empty((6, size)), np.empty((size, size))
    for leg in range(n):
        for k in range(K):
            chain(legs, leg, q[leg, k], links)
            contact_point(legs, leg, links, p[leg, k], J)
            contact_jacobian(zeros, links.R[size], J, E)
            contact_rows(zeros, links.R[size], v[leg, k], w[leg, k], u[leg, k])
            inverse = damped_inverse(zeros, E, nominal)
            for i in range(size):
                for j in range(size):
                    inverses[leg, k, i, j] = inverse[i, j]
            for i in range(3):
                for j in range(3):
                    R[leg, k, i, j] = links.R[size, i, j]
    return p, R, inverses, u


@compiled
def contact_maps(
    legs: Legs, q: Array, maps: MomentumMaps, v: Array, w: Array, m: float, nominal: float
) -> tuple[Array, Array]:
    """Return A_c and c at K times, see the module.

    Args:
        legs: both legs.
        q: joint angles [rad], shape (2, K, j).
        maps: momenta of turning and of the joints at these angles.
        v: velocities of the lines' middles in W, with the axes of B [m/s], shape (2, K, 3).
        w: angular velocities, alike [rad/s]; the part along a line does not count.
        m: mass [kg].
        nominal: determinant of a leg's Jacobian in the nominal posture, see `determinant`.

    Returns:
        (A, c): shapes (K, 6, 6) and (K, 6), angular over linear, about the CoM, in B.
    """
    p, R, inverses, u = planned_lines(legs, q, v, w, nominal)
    K, size = len(maps.com), len(legs.zeros)
    A, c = np.zeros((K, 6, 6)), np.zeros((K, 6))
    joint, rows = np.empty((6, size)), np.zeros((size, 6))  # A_i and K_i
    G, G_K, G_u = np.empty((6, size)), np.empty((6, 6)), np.empty(6)
    for k in range(K):
        for i in range(3):
            A[k, 3 + i, 3 + i], rows[i, 3 + i] = m, 1.0
            for j in range(3):
                A[k, i, j] = maps.I_B[k, i, j]
        for leg in range(len(q)):
            for i in range(3):
                after, before = (i + 1) % 3, (i + 2) % 3  # of [com - p]x
                rows[i, before] = maps.com[k, after] - p[leg, k, after]
                rows[i, after] = p[leg, k, before] - maps.com[k, before]
                for j in range(3, size):
                    rows[j, i] = R[leg, k, i, TORQUE_AXES[j - 3]]
                for j in range(size):
                    joint[i, j] = maps.angular[leg, k, i, j]
                    joint[3 + i, j] = maps.linear[leg, k, i, j]
            times(joint, inverses[leg, k], G, size)
            times(G, rows, G_K, 6)
            times_vector(G, u[leg, k], G_u)
            for i in range(6):
                c[k, i] += G_u[i]
                for j in range(6):
                    A[k, i, j] -= G_K[i, j]
    return A, c


@compiled
def eliminated(A: Array, B: Array) -> Array:
    """Return the solution of ``A X = B``, not finite where A is singular; (n, n) and (n, m)."""
    n, m = B.shape
    U, X = np.empty((n, n + m)), np.full((n, m), np.nan)
    for i in range(n):
        for j in range(n):
            U[i, j] = A[i, j]
        for j in range(m):
            U[i, n + j] = B[i, j]
    if eliminate(U, 0.0):
        for i in range(n - 1, -1, -1):
            for j in range(m):
                X[i, j] = U[i, n + j]
                for k in range(i + 1, n):
                    X[i, j] -= U[i, k] * X[k, j]
                X[i, j] /= U[i, i]
    return X


@inlined
def torso_rates(A: Array) -> Array:
    """Return E, which takes [L; m r'] to the torso's angular velocity, shape (K, 3, 6).

    Args:
        A: A_c of `contact_maps`, shape (K, 6, 6); where it is singular, E is not finite.
    """
    E, unit = np.empty((len(A), 3, 6)), np.eye(6)
    for k in range(len(A)):
        inverse = eliminated(A[k], unit)
        for i in range(3):
            for j in range(6):
                E[k, i, j] = inverse[i, j]
    return E


@inlined
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
    L, rest, lower = np.empty(Omega.shape), np.empty((3, 1)), np.empty((3, 3))
    for k in range(len(A)):
        for i in range(3):
            rest[i, 0] = p[k, i] - c[k, 3 + i]
            for j in range(3):
                rest[i, 0] -= A[k, 3 + i, j] * Omega[k, j]
                lower[i, j] = A[k, 3 + i, 3 + j]
        v_P = eliminated(lower, rest)
        for i in range(3):
            L[k, i] = c[k, i]
            for j in range(3):
                L[k, i] += A[k, i, j] * Omega[k, j] + A[k, i, 3 + j] * v_P[j, 0]
    return L


@compiled
def flies(contact: Array) -> bool:
    """Return whether no foot stands in some interval; flags of feet in them, shape (K, 2)."""
    for k in range(len(contact)):
        if contact[k, 0] == 0.0 and contact[k, 1] == 0.0:
            return True
    return False


@compiled
def consistent_legs(reference: Array, lines: LinePlan, dynamics: Array, robot: Robot) -> float:
    """Write a reference with legs that let the torso turn over the feet; else as `planned_legs`.

    That altogether where the robot flies: the footholds of a run go with its velocity, so they do
    not hold the torso.
    """
    ref = open_reference(reference, lines.p.shape[1])
    if flies(ref.contact):
        return float(planned_legs(reference, lines, dynamics, robot))
    now = open_dynamics(dynamics, robot.nv, robot.nw)
    body = middles(ref)
    angles, maps, reach = reaching_legs(body, lines, now, robot)
    v, w = rates_in_torso(body, lines)
    A, c = contact_maps(robot.legs, angles, maps, v, w, robot.mass, robot.determinant)
    p = np.empty(body.v.shape)
    for k in range(len(p)):
        write(p, k, 0, scaled(robot.mass, turned_back(body.R, k, vector(body.v, k, 0))))
    copy(maps.I_B, ref.I_B)
    copy(torso_rates(A), ref.E)
    legs = angular_momentum(A, c, body.Omega, p)
    write_momentum(ref, legs + arm_momentum(ref, lines, now, robot))
    return reach


def consistent_knots(
    horizon: GaitHorizon, begin: float, count: int, step: float, period: float
) -> Array:
    """Return knots of which the second comes just after the use of a plan, see `Model`.

    How a swinging leg turns the torso changes that fast. Not so in a run, where wrenches of an
    interval that is as short as that jump from plan to plan.
    """
    if count == 1 or flies(horizon.contact[: int(horizon.phases)]):
        return knots(horizon, begin, count, step)
    used = knots(horizon, begin, 1, min(period + 2.0 * TIME_EPSILON, step))
    return np.append(used[:1], knots(horizon, used[1], count - 1, step))


def moving_legs(reference: Reference) -> Linearisation:
    """Return what the torso turns about over its feet, with no joint locked unless it flies.

    Raises:
        InputError: the reference has no E, since another model made it.
    """
    if flies(reference.contact):
        return Linearisation.of(reference)
    if not reference.E.any():
        needed = "must not be 0: the model contact_consistent takes the torso's rate from it"
        raise InputError("reference", "E", 0.0, needed)
    return Linearisation.of(reference, reference.E)


CONTACT_CONSISTENT = Model(
    "contact_consistent",
    "contact-consistent",
    consistent_legs,
    knots=consistent_knots,
    linearise=moving_legs,
)
