"""Enhanced Centroidal Dynamics, (23)-(39), for all intervals of a horizon at once.

The state is ``x = [r, r', L_G, eta]`` and the input ``u`` holds, for each foot, the force in
world and ``[tau_y, tau_z]`` in the contact frame, (36).
"""

from typing import NamedTuple, Self

import numpy as np

from drake_linefoot.centroidal import NO_WRENCH
from drake_linefoot.constants import GRAVITY
from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.linear import solve_positive
from drake_linefoot.math.rotation import cross, crosses, skews
from drake_linefoot.signals import Reference
from drake_linefoot.types import Array

LOCKED = np.empty((0, 3, 6))  # E of models in which the joints count as locked
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

    @classmethod
    def of(cls, ref: Reference) -> Self:
        """Return what a reference says in the middle of its intervals."""
        E = ref.E if ref.turns else LOCKED
        return cls(ref.I_B, ref.R_mid, ref.Omega_mid, ref.L_mid, ref.r_mid, ref.v_mid, E)


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
    R_BW = about.R_d.swapaxes(1, 2)
    if len(about.E):
        a3, E_v = about.E[..., :3] @ R_BW, m * (about.E[..., 3:] @ R_BW)
        a4 = np.zeros_like(a3)
    else:
        I_inverse = _inverses(about.I_B)
        a3, E_v = I_inverse @ R_BW, np.zeros_like(I_inverse)
        a4 = I_inverse @ skews(np.matvec(R_BW, about.L_d)) - skews(about.Omega_d)
    a0 = np.matvec(a3, m * crosses(about.r_d, about.v_d) - about.L_d) - np.matvec(E_v, about.v_d)
    a1 = a3 @ (m * skews(about.v_d))
    a2 = a3 @ (-m * skews(about.r_d - r_G)) + E_v
    return a0, a1, a2, a3, a4


@compiled
def _inverses(I_B: Array) -> Array:
    """Return the inverse of each inertia, NaN where it is not positive definite."""
    inverses = np.full_like(I_B, np.nan)
    for k in range(len(I_B)):
        found, positive = solve_positive(I_B[k], np.eye(3))
        if positive:
            inverses[k] = found
    return inverses


def system_matrices(
    about: Linearisation, r_G: Array, m: float, external: Array = NO_WRENCH
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
    K, pull = len(about.r_d), m * GRAVITY + external[3:]
    A, C = np.zeros((K, STATES, STATES)), np.zeros((K, STATES))
    a0, a1, a2, a3, a4 = orientation_terms(about, r_G, m)
    A[:, :3, 3:6] = np.eye(3)
    A[:, 6:9, :3] = -skews(pull)
    A[:, 9:, :3], A[:, 9:, 3:6], A[:, 9:, 6:9], A[:, 9:, 9:] = a1, a2, a3, a4
    C[:, 3:6], C[:, 6:9], C[:, 9:] = pull / m, external[:3] - cross(r_G, pull), a0
    return A, C


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
    B = np.zeros((len(p_WC), STATES, INPUTS))
    for foot in range(2):
        f = FOOT_INPUTS * foot  # then the torques
        B[:, 3:6, f : f + 3] = np.eye(3) / m
        B[:, 6:9, f : f + 3] = skews(p_WC[:, foot] - r_G)
        B[:, 6:9, f + 3 : f + 5] = R_WC[:, foot, :, 1:]
    return B


def centroidal_state(r: Array, v: Array, L: Array, eta: Array, r_G: Array, m: float) -> Array:
    """Return ``[r, r', L_G, eta]`` with ``L_G = L + m (r - r_G) x r'``.

    Args:
        r: CoM [m], shape (..., 3).
        v: its velocity [m/s], shape (..., 3).
        L: angular momentum about the CoM [kg m^2/s], shape (..., 3).
        eta: rotation vector from desired to actual torso [rad], shape (..., 3).
        r_G: fixed point [m], shape (3,).
        m: mass [kg].

    Returns:
        Shape (..., 12).
    """
    return np.concatenate([r, v, L + m * crosses(r - r_G, v), eta], axis=-1)
