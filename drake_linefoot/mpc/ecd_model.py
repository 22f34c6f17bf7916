"""Enhanced Centroidal Dynamics, (23)-(39), for all intervals of a horizon at once.

The state is ``x = [r, r', L_G, eta]`` and the input ``u`` holds, for each foot, the force in
world and ``[tau_y, tau_z]`` in the contact frame, (36).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.math.so3 import cross_rows
from drake_linefoot.mpc import kernels

Array = NDArray[np.float64]

STATES = 12
INPUTS = 10
FOOT_INPUTS = 5


@dataclass(frozen=True)
class Linearisation:
    """The reference that the orientation is linearised about, (28), (29).

    Attributes:
        I_B: locked inertia in B [kg m^2], shape (K, 3, 3).
        R_d: torso orientation, shape (K, 3, 3).
        Omega_d: torso angular velocity in B [rad/s], shape (K, 3).
        L_d: angular momentum about the CoM in W [kg m^2/s], shape (K, 3).
        r_d: CoM [m], shape (K, 3).
        v_d: its velocity [m/s], shape (K, 3).
    """

    I_B: Array
    R_d: Array
    Omega_d: Array
    L_d: Array
    r_d: Array
    v_d: Array


def orientation_terms(
    about: Linearisation, r_G: Array, m: float
) -> tuple[Array, Array, Array, Array, Array]:
    """Return a_0 ... a_4 of (31), the linearised rate of eta, (30).

    Args:
        about: the reference.
        r_G: fixed point of L_G [m], shape (3,).
        m: mass [kg].

    Returns:
        (a0, a1, a2, a3, a4): shapes (K, 3) and four times (K, 3, 3).
    """
    return kernels.orientation_terms(
        about.I_B, about.R_d, about.Omega_d, about.L_d, about.r_d, about.v_d, r_G, m
    )


def system_matrices(
    about: Linearisation, r_G: Array, m: float, gravity: Array
) -> tuple[Array, Array]:
    """Return A(t) of (37) and C(t) of (39).

    Args:
        about: the reference in K intervals.
        r_G: fixed point of L_G [m], shape (3,).
        m: mass [kg].
        gravity: [m/s^2], shape (3,).

    Returns:
        (A, C) of shapes (K, 12, 12) and (K, 12).
    """
    return kernels.system_matrices(*orientation_terms(about, r_G, m), r_G, m, gravity)


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
    return kernels.input_matrices(p_WC, R_WC, r_G, m)


def centroidal_state(r: Array, v: Array, L_com: Array, eta: Array, r_G: Array, m: float) -> Array:
    """Return ``[r, r', L_G, eta]`` with ``L_G = L + m (r - r_G) x r'``.

    Args:
        r: CoM [m], shape (..., 3).
        v: its velocity [m/s], shape (..., 3).
        L_com: angular momentum about the CoM [kg m^2/s], shape (..., 3).
        eta: rotation vector from desired to actual torso [rad], shape (..., 3).
        r_G: fixed point [m], shape (3,).
        m: mass [kg].

    Returns:
        Shape (..., 12).
    """
    L_fixed = L_com + m * cross_rows(r - r_G, v)
    return np.concatenate([r, v, L_fixed, eta], axis=-1)
