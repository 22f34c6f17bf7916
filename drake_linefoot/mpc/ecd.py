"""Enhanced Centroidal Dynamics, (23)-(39), for all intervals of a horizon at once.

The state is ``x = [r, r', L_G, eta]`` and the input ``u`` holds, for each foot, the force in
world and torques in the contact frame, (36): nw numbers, see `contact.contacts`.
"""

from typing import NamedTuple, Self

import numpy as np

from drake_linefoot.axes import TORQUE_AXES
from drake_linefoot.constants import GRAVITY
from drake_linefoot.math.compiled import inlined
from drake_linefoot.math.linear import solve_positive
from drake_linefoot.math.rotation import cross, skew
from drake_linefoot.math.vectors import (
    crossed,
    inner,
    plus,
    times,
    turned,
    turned_back,
    vector,
    write,
)
from drake_linefoot.signals import Reference
from drake_linefoot.types import Array

LOCKED = np.empty((0, 3, 6))  # E of models in which the joints count as locked
STATES = 12


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

    @classmethod
    def of(cls, ref: Reference, E: Array = LOCKED) -> Self:
        """Return what a reference says in the middle of its intervals."""
        return cls(ref.I_B, ref.R_mid, ref.Omega_mid, ref.L_mid, ref.r_mid, ref.v_mid, E)


@inlined
def orientation_terms(
    about: Linearisation, r_G: Array, m: float
) -> tuple[Array, Array, Array, Array, Array]:
    """Return a_0 ... a_4 of (31), the linearised rate of eta, (30), in K intervals.

    With E the torso turns over its feet and the legs follow: ``R'(w - w_d) = E_L R'(L - L_d) +
    E_v R' m (r' - r'_d)``. Nothing is locked. Left out is what a small turn of the torso changes of
    E, and what a shift of the CoM does at given L and feet: a seventh of the whole derivative by r
    in a walk at 0.5 m/s, a milliradian along a plan, see docs/mathematics.md.

    Args:
        about: the reference.
        r_G: fixed point of L_G [m], shape (3,).
        m: mass [kg].

    Returns:
        (a0, a1, a2, a3, a4): shapes (K, 3) and four times (K, 3, 3); not finite where an inertia
        that is asked for is not positive definite.
    """
    K, locked, unit = len(about.R_d), len(about.E) == 0, np.eye(3)
    a0, a = np.empty((K, 3)), np.zeros((4, K, 3, 3))
    fixed = (-r_G[0], -r_G[1], -r_G[2])
    for k in range(K):
        r_d, v_d = vector(about.r_d, k, 0), vector(about.v_d, k, 0)
        L_d, arm = vector(about.L_d, k, 0), plus(r_d, fixed)
        rest = plus(times(m, crossed(r_d, v_d)), times(-1.0, L_d))
        inverse, positive = unit, True
        if locked:
            inverse, positive = solve_positive(about.I_B[k], unit)
        for i in range(3):  # row by row: b' [c]x is (b x c)'
            if locked:
                E_L, E_v = vector(inverse, i, 0), (0.0, 0.0, 0.0)
                if not positive:
                    E_L = (np.nan, np.nan, np.nan)
                L_B = turned_back(about.R_d, k, L_d)
                turning = crossed(vector(unit, i, 0), vector(about.Omega_d, k, 0))
                write(a[3, k], i, 0, plus(crossed(E_L, L_B), times(-1.0, turning)))
            else:
                E_L = vector(about.E[k], i, 0)
                E_v = times(m, turned(about.R_d, k, vector(about.E[k], i, 3)))
            a3 = turned(about.R_d, k, E_L)
            write(a[0, k], i, 0, times(m, crossed(a3, v_d)))
            write(a[1, k], i, 0, plus(times(-m, crossed(a3, arm)), E_v))
            write(a[2, k], i, 0, a3)
            a0[k, i] = inner(a3, rest) - inner(E_v, v_d)
    return a0, a[0], a[1], a[2], a[3]


@inlined
def system_matrices(
    about: Linearisation, r_G: Array, m: float, external: Array
) -> tuple[Array, Array]:
    """Return A(t) of (37) and C(t) of (39).

    A constant force on the robot acts as gravity does, at the CoM, with a moment about it.

    Args:
        about: the reference in K intervals.
        r_G: fixed point of L_G [m], shape (3,).
        m: mass [kg].
        external: that force under its moment, see `GaitTargets` [N m, N], shape (6,).

    Returns:
        (A, C) of shapes (K, 12, 12) and (K, 12).
    """
    K, pull = len(about.r_d), np.empty(3)
    A, C = np.zeros((K, STATES, STATES)), np.zeros((K, STATES))
    a0, a1, a2, a3, a4 = orientation_terms(about, r_G, m)
    for i in range(3):
        pull[i] = m * GRAVITY[i] + external[3 + i]
    turning, moment = skew(pull), cross(r_G, pull)
    for k in range(K):
        for i in range(3):
            A[k, i, 3 + i] = 1.0
            C[k, 3 + i], C[k, 6 + i] = pull[i] / m, external[i] - moment[i]
            C[k, 9 + i] = a0[k, i]
            for j in range(3):
                A[k, 6 + i, j] = -turning[i, j]
                A[k, 9 + i, j], A[k, 9 + i, 3 + j] = a1[k, i, j], a2[k, i, j]
                A[k, 9 + i, 6 + j], A[k, 9 + i, 9 + j] = a3[k, i, j], a4[k, i, j]
    return A, C


@inlined
def input_matrices(p_WC: Array, R_WC: Array, r_G: Array, m: float, nw: int) -> Array:
    """Return B(t) of (38).

    Args:
        p_WC: contact lines [m], shape (K, 2, 3).
        R_WC: contact frames, shape (K, 2, 3, 3).
        r_G: fixed point of L_G [m], shape (3,).
        m: mass [kg].
        nw: how many numbers the wrench of a foot has.

    Returns:
        Shape (K, 12, 2 nw).
    """
    B = np.zeros((len(p_WC), STATES, 2 * nw))
    for k in range(len(p_WC)):
        for foot in range(2):
            f = nw * foot  # then the torques
            for i in range(3):
                B[k, 3 + i, f + i] = 1.0 / m
                after, before = (i + 1) % 3, (i + 2) % 3  # of [p - r_G]x
                B[k, 6 + i, f + before] = p_WC[k, foot, after] - r_G[after]
                B[k, 6 + i, f + after] = r_G[before] - p_WC[k, foot, before]
                for j in range(nw - 3):
                    B[k, 6 + i, f + 3 + j] = R_WC[k, foot, i, TORQUE_AXES[j]]
    return B


@inlined
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
    x, arm = np.empty(STATES), (r[0] - r_G[0], r[1] - r_G[1], r[2] - r_G[2])
    moving = crossed(arm, (v[0], v[1], v[2]))
    for i in range(3):
        x[i], x[3 + i], x[6 + i], x[9 + i] = r[i], v[i], L[i] + m * moving[i], eta[i]
    return x
