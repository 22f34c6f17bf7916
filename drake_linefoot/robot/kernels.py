"""Compiled parts of the dynamics of one state."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.kernels import from_quaternion

Array = NDArray[np.float64]


@compiled
def contact_frame(R_WF: Array) -> Array:
    """Return R_WC: x along the foot's x axis, y level, z completing it.

    Args:
        R_WF: foot orientation, shape (3, 3).

    Returns:
        Shape (3, 3).

    Raises:
        ValueError: the foot's line stands upright, so that it has no heading.
    """
    R_WC = np.empty((3, 3))
    x0, x1, x2 = R_WF[0, 0], R_WF[1, 0], R_WF[2, 0]
    norm = math.hypot(x0, x1)
    if norm < 1e-9:
        raise ValueError("the contact line stands upright: it has no heading")
    y0, y1 = -x1 / norm, x0 / norm
    R_WC[0, 0], R_WC[1, 0], R_WC[2, 0] = x0, x1, x2
    R_WC[0, 1], R_WC[1, 1], R_WC[2, 1] = y0, y1, 0.0
    R_WC[0, 2], R_WC[1, 2], R_WC[2, 2] = -x2 * y1, x2 * y0, x0 * y1 - x1 * y0
    return R_WC


@compiled
def line_motion(
    X_WF: Array,
    p_FC: Array,
    J_V: Array,
    bias: Array,
    v: Array,
    p_WC: Array,
    R_WC: Array,
    v_WC: Array,
    w_WF: Array,
    J: Array,
    Jdot_v: Array,
) -> None:
    """Write the motion of one contact line into the last six arguments.

    Args:
        X_WF: pose of the foot, rotation beside origin, shape (3, 4).
        p_FC: middle of the line in the foot [m], shape (3,).
        J_V: Jacobian of the foot's spatial velocity at C, angular over linear, shape (6, nv).
        bias: bias of that velocity's rate, shape (6,).
        v: velocities, shape (nv,).
        p_WC: becomes the middle of the line [m], shape (3,).
        R_WC: becomes the contact frame, shape (3, 3).
        v_WC: becomes the velocity of the middle [m/s], shape (3,).
        w_WF: becomes the angular velocity of the foot [rad/s], shape (3,).
        J: becomes the line-contact Jacobian (51), shape (5, nv).
        Jdot_v: becomes the bias of (51), shape (5,).

    Raises:
        ValueError: the line stands upright.
    """
    R_WC[:] = contact_frame(X_WF)
    for i in range(3):
        p_WC[i] = X_WF[i, 3]
        for k in range(3):
            p_WC[i] += X_WF[i, k] * p_FC[k]
        Jdot_v[i] = bias[3 + i]
    for i in range(2):  # A_s' R_i of (51)
        Jdot_v[3 + i] = 0.0
        for k in range(3):
            Jdot_v[3 + i] += R_WC[k, 1 + i] * bias[k]
    v_WC[:] = 0.0
    w_WF[:] = 0.0
    for j in range(len(v)):
        for i in range(3):
            J[i, j] = J_V[3 + i, j]
        for i in range(2):
            J[3 + i, j] = (
                R_WC[0, 1 + i] * J_V[0, j] + R_WC[1, 1 + i] * J_V[1, j] + R_WC[2, 1 + i] * J_V[2, j]
            )
        for i in range(3):
            w_WF[i] += J_V[i, j] * v[j]
            v_WC[i] += J_V[3 + i, j] * v[j]


@compiled
def base_terms(
    M: Array,
    Cv: Array,
    r: Array,
    v: Array,
    g: Array,
    A: Array,
    Adot_v: Array,
    tau_g: Array,
    v_WG: Array,
) -> None:
    """Write what the six base rows of the dynamics say into the last four arguments.

    Args:
        M: mass matrix of a floating base whose velocity starts at 0, shape (nv, nv).
        Cv: Coriolis and centrifugal forces, shape (nv,).
        r: CoM relative to the base origin in world [m], shape (3,).
        v: velocities, shape (nv,).
        g: gravity [m/s^2], shape (3,).
        A: becomes the centroidal momentum matrix, angular about the CoM over linear, (6, nv).
        Adot_v: becomes the rate of that momentum at vdot = 0, shape (6,).
        tau_g: becomes the generalized gravity forces, shape (nv,).
        v_WG: becomes the velocity of the CoM [m/s], shape (3,).
    """
    x, y, z = r
    v_WG[:] = 0.0
    for j in range(len(v)):
        l0, l1, l2 = M[3, j], M[4, j], M[5, j]
        A[0, j] = M[0, j] - (y * l2 - z * l1)
        A[1, j] = M[1, j] - (z * l0 - x * l2)
        A[2, j] = M[2, j] - (x * l1 - y * l0)
        A[3, j], A[4, j], A[5, j] = l0, l1, l2
        for i in range(3):
            v_WG[i] += M[3 + i, j] * v[j]
        tau_g[j] = g[0] * l0 + g[1] * l1 + g[2] * l2
    v_WG /= M[3, 3]  # of the diagonal mass block
    Adot_v[0] = Cv[0] - (y * Cv[5] - z * Cv[4])
    Adot_v[1] = Cv[1] - (z * Cv[3] - x * Cv[5])
    Adot_v[2] = Cv[2] - (x * Cv[4] - y * Cv[3])
    Adot_v[3:] = Cv[3:6]


@compiled
def state_terms(
    M: Array,
    Cv: Array,
    q: Array,
    v: Array,
    g: Array,
    p_WG: Array,
    X_WF: tuple[Array, Array],
    p_FC: Array,
    J_V: tuple[Array, Array],
    bias: tuple[Array, Array],
    A: Array,
    tau_g: Array,
    base: Array,
    R_WB: Array,
    lines: Array,
    R_WC: Array,
    J: Array,
) -> None:
    """Write all that follows from Drake's quantities of a state into the last seven arguments.

    Args:
        M: mass matrix, shape (nv, nv).
        Cv: Coriolis and centrifugal forces, shape (nv,).
        q: positions, shape (nq,).
        v: velocities, shape (nv,).
        g: gravity [m/s^2], shape (3,).
        p_WG: CoM [m], shape (3,).
        X_WF: poses of both feet, rotation beside origin, shapes (3, 4).
        p_FC: middle of each line in its foot [m], shape (2, 3).
        J_V: Jacobians of the feet's spatial velocities at C, shapes (6, nv).
        bias: biases of those velocities' rates, shapes (6,).
        A: becomes the centroidal momentum matrix, shape (6, nv).
        tau_g: becomes the generalized gravity forces, shape (nv,).
        base: becomes the bias of the momentum's rate and the velocity of the CoM, shape (9,).
        R_WB: becomes the torso orientation, shape (3, 3).
        lines: becomes p_WC, v_WC, w_WF and Jdot_v of each line, shape (2, 14).
        R_WC: becomes the contact frames, shape (2, 3, 3).
        J: becomes the line-contact Jacobians (51), shape (2, 5, nv).

    Raises:
        ValueError: the line of a foot stands upright.
    """
    base_terms(M, Cv, p_WG - q[4:7], v, g, A, base[:6], tau_g, base[6:])
    R_WB[:] = from_quaternion(q)
    for side in range(2):
        line = lines[side]
        line_motion(
            X_WF[side], p_FC[side], J_V[side], bias[side], v,
            line[:3], R_WC[side], line[3:6], line[6:9], J[side], line[9:],
        )  # fmt: skip
