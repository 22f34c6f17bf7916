"""Enhanced Centroidal Dynamics, (23)-(39), for all intervals of a horizon at once.

The state is ``x = [r, r', L_G, eta]`` and the input ``u`` holds, for each foot, the force in
world and ``[tau_y, tau_z]`` in the contact frame, (36).
"""

from typing import NamedTuple

import numpy as np

from drake_linefoot.constants import GRAVITY
from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.linear import solve_positive
from drake_linefoot.math.rotation import cross, skew
from drake_linefoot.signals import LOCKED
from drake_linefoot.types import Array

STATES = 12
INPUTS = 10
FOOT_INPUTS = 5


class Linearisation(NamedTuple):
    """The reference that the orientation is linearised about, (28), (29).

    Attributes:
        I_B: locked inertia in B [kg m^2], shape (K, 3, 3).
        R_d: torso orientation, shape (K, 3, 3).
        Omega_d: torso angular velocity in B [rad/s], shape (K, 3).
        L_d: angular momentum about the CoM in W [kg m^2/s], shape (K, 3).
        r_d: CoM [m], shape (K, 3).
        v_d: its velocity [m/s], shape (K, 3).
        E: how the torso turns over feet that move as planned, see `Reference`, shape (K, 3, 6);
            without rows the joints count as locked, (25).
    """

    I_B: Array
    R_d: Array
    Omega_d: Array
    L_d: Array
    r_d: Array
    v_d: Array
    E: Array = LOCKED


@compiled
def orientation_terms(
    about: Linearisation, k: int, r_G: Array, m: float
) -> tuple[Array, Array, Array, Array, Array]:
    """Return a_0 ... a_4 of (31), the linearised rate of eta, (30), in one interval.

    Args:
        about: the reference.
        k: the interval.
        r_G: fixed point of L_G [m], shape (3,).
        m: mass [kg].

    Returns:
        (a0, a1, a2, a3, a4): shapes (3,) and four times (3, 3); not finite where the inertia is
        not positive definite.
    """
    R, Omega, L, r, v = (
        about.R_d[k], about.Omega_d[k], about.L_d[k], about.r_d[k], about.v_d[k],
    )  # fmt: skip
    I_inverse, positive = solve_positive(about.I_B[k], np.eye(3))
    if not positive:
        I_inverse[:] = np.nan
    a3 = I_inverse @ R.T
    a0 = a3 @ (m * cross(r, v) - L)
    a1 = a3 @ (m * skew(v))
    a2 = a3 @ (-m * skew(r - r_G))
    a4 = I_inverse @ skew(R.T @ L) - skew(Omega)
    return a0, a1, a2, a3, a4


@compiled
def contact_consistent_terms(
    about: Linearisation, k: int, r_G: Array, m: float
) -> tuple[Array, Array, Array, Array, Array]:
    """Return the same where the torso turns over its feet and the legs follow.

    ``R'(w - w_d) = E_L R'(L - L_d) + E_v R' m (r' - r'_d)``: nothing is locked, and what a small
    turn of the torso changes of E is left out, see docs/mathematics.md.

    Args:
        about: the reference, with E.
        k: the interval.
        r_G: fixed point of L_G [m], shape (3,).
        m: mass [kg].

    Returns:
        See `orientation_terms`.
    """
    R, L, r, v = about.R_d[k], about.L_d[k], about.r_d[k], about.v_d[k]
    E_L = np.ascontiguousarray(about.E[k, :, :3]) @ R.T
    E_v = m * (np.ascontiguousarray(about.E[k, :, 3:]) @ R.T)
    a0 = E_L @ (m * cross(r, v) - L) - E_v @ v
    a1 = E_L @ (m * skew(v))
    a2 = E_L @ (-m * skew(r - r_G)) + E_v
    return a0, a1, a2, E_L, np.zeros((3, 3))


@compiled
def system_matrices(about: Linearisation, r_G: Array, m: float) -> tuple[Array, Array]:
    """Return A(t) of (37) and C(t) of (39).

    Args:
        about: the reference in K intervals.
        r_G: fixed point of L_G [m], shape (3,).
        m: mass [kg].

    Returns:
        (A, C) of shapes (K, 12, 12) and (K, 12).
    """
    K = len(about.r_d)
    A, C = np.zeros((K, STATES, STATES)), np.zeros((K, STATES))
    for k in range(K):
        if len(about.E):
            a0, a1, a2, a3, a4 = contact_consistent_terms(about, k, r_G, m)
        else:
            a0, a1, a2, a3, a4 = orientation_terms(about, k, r_G, m)
        A[k, :3, 3:6] = np.eye(3)
        A[k, 6:9, :3] = -m * skew(GRAVITY)
        A[k, 9:, :3], A[k, 9:, 3:6], A[k, 9:, 6:9], A[k, 9:, 9:] = a1, a2, a3, a4
        C[k, 3:6] = GRAVITY
        C[k, 6:9] = -m * cross(r_G, GRAVITY)
        C[k, 9:] = a0
    return A, C


@compiled
def input_matrices(p_WC: Array, R_WC: Array, r_G: Array, m: float) -> Array:
    """Return B(t) of (38).

    Args:
        p_WC: contact lines [m], shape (K, 2, 3).
        R_WC: contact frames, shape (K, 2, 3, 3).
        r_G: fixed point of L_G [m], shape (3,).
        m: mass [kg].

    Returns:
        Shape (K, 12, 10).
    """
    K = len(p_WC)
    B = np.zeros((K, STATES, INPUTS))
    for k in range(K):
        for foot in range(2):
            f = FOOT_INPUTS * foot  # then the torques
            B[k, 3:6, f : f + 3] = np.eye(3) / m
            B[k, 6:9, f : f + 3] = skew(p_WC[k, foot] - r_G)
            B[k, 6:9, f + 3 : f + 5] = R_WC[k, foot, :, 1:]
    return B


@compiled
def centroidal_state(r: Array, v: Array, L: Array, eta: Array, r_G: Array, m: float) -> Array:
    """Return ``[r, r', L_G, eta]`` with ``L_G = L + m (r - r_G) x r'``.

    Args:
        r: CoM [m], shape (3,).
        v: its velocity [m/s], shape (3,).
        L: angular momentum about the CoM [kg m^2/s], shape (3,).
        eta: rotation vector from desired to actual torso [rad], shape (3,).
        r_G: fixed point [m], shape (3,).
        m: mass [kg].

    Returns:
        Shape (12,).
    """
    x = np.empty(STATES)
    x[:3], x[3:6], x[6:9], x[9:] = r, v, L + m * cross(r - r_G, v), eta
    return x
