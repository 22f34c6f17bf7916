"""Compiled parts of a tick of the whole-body controller."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.contact.cone_kernels import turned_cone
from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.kernels import backward, cholesky, forward, orthonormal_rows

Array = NDArray[np.float64]


@compiled
def prioritised(M: Array, J: Array, b: Array, tolerance: float) -> tuple[Array, int, bool]:
    """Return the acceleration that meets the rows ``J vdot = b`` one after the other.

    Args:
        M: mass matrix, shape (nv, nv).
        J: rows, highest priority first, shape (m, nv).
        b: shape (m,).
        tolerance: a row that rows above leave less of than this share is dropped.

    Returns:
        (vdot, dropped, positive): shape (nv,), the number of dropped rows, and whether the
        mass matrix is positive definite.
    """
    n, m = len(M), len(b)
    L, positive = cholesky(M)
    if not positive:
        return np.zeros(n), 0, False
    J_hat = J.T.copy()
    forward(L, J_hat)
    Q, R, kept = orthonormal_rows(J_hat.T.copy(), tolerance)
    z, y, dropped = np.zeros((n, 1)), np.zeros(m), 0
    for i in range(m):
        if not kept[i]:
            dropped += 1
            continue
        s = b[i]
        for j in range(i):
            s -= R[i, j] * y[j]
        y[i] = s / R[i, i]
        for k in range(n):
            z[k, 0] += y[i] * Q[i, k]
    backward(L, z)
    return z[:, 0].copy(), dropped, True


@compiled
def momentum_wish(
    mass: float,
    gains: tuple[float, float, float],
    plan: Array,
    p_WG: Array,
    v_WG: Array,
    A: Array,
    v: Array,
    Adot_v: Array,
) -> Array:
    """Return the right side of the momentum task, (52), (53).

    Args:
        mass: [kg].
        gains: K_P,r, K_D,r and K_P,L.
        plan: CoM, velocity, acceleration, angular momentum about the CoM and its rate, (5, 3).
        p_WG: measured CoM [m], shape (3,).
        v_WG: its velocity [m/s], shape (3,).
        A: centroidal momentum matrix, shape (6, nv).
        v: velocities, shape (nv,).
        Adot_v: bias of the momentum's rate, shape (6,).

    Returns:
        Rates of angular and linear momentum less their bias, shape (6,).
    """
    wish = np.empty(6)
    r, r_dot, r_ddot, L, L_dot = plan[0], plan[1], plan[2], plan[3], plan[4]
    for i in range(3):
        L_G = 0.0
        for j in range(len(v)):
            L_G += A[i, j] * v[j]
        wish[i] = L_dot[i] - gains[2] * (L_G - L[i]) - Adot_v[i]
        a = r_ddot[i] - gains[1] * (v_WG[i] - r_dot[i]) - gains[0] * (p_WG[i] - r[i])
        wish[3 + i] = mass * a - Adot_v[3 + i]
    return wish


@compiled
def swing_wish(kp: float, kd: float, target: Array, line: Array, R_WC: Array) -> Array:
    """Return the right side of the swing task.

    Args:
        kp: [1/s^2].
        kd: [1/s].
        target: where the middle of the line should be, its velocity and acceleration, the
            line's direction, angular velocity and acceleration, shape (6, 3).
        line: p_WC, v_WC, w_WF and Jdot_v of the line, shape (14,).
        R_WC: contact frame, shape (3, 3).

    Returns:
        Shape (5,).
    """
    p_WC, v_WC, w_WF = line[:3], line[3:6], line[6:9]
    p_d, v_d, a_d = target[0], target[1], target[2]
    d, w_d, alpha_d = target[3], target[4], target[5]
    wish = -line[9:]
    x = R_WC[:, 0]
    turn = (x[1] * d[2] - x[2] * d[1], x[2] * d[0] - x[0] * d[2], x[0] * d[1] - x[1] * d[0])
    for i in range(3):
        wish[i] += a_d[i] + kd * (v_d[i] - v_WC[i]) + kp * (p_d[i] - p_WC[i])
        angular = alpha_d[i] + kd * (w_d[i] - w_WF[i]) + kp * turn[i]
        wish[3] += R_WC[i, 1] * angular
        wish[4] += R_WC[i, 2] * angular
    return wish


@compiled
def reduced(
    M: Array,
    vdot: Array,
    Cv: Array,
    tau_g: Array,
    J_b: Array,
    u: Array,
    Q1: Array,
    Q2: float,
) -> tuple[Array, Array, Array, Array, bool]:
    """Eliminate the six base rows of (49); see `wrench_qp.reduce_program`.

    Args:
        M: mass matrix, shape (nv, nv).
        vdot: commanded acceleration, shape (nv,).
        Cv: Coriolis and centrifugal forces, shape (nv,).
        tau_g: gravity forces, shape (nv,).
        J_b: base columns of the contact Jacobian, shape (n, 6).
        u: the MPC's wish, shape (n,).
        Q1: weight of the corrections, shape (n, n).
        Q2: weight of the base acceleration error.

    Returns:
        (H, g, G, c, positive): cost of the corrections, shapes (n, n) and (n,), base
        acceleration error ``G d + c``, shapes (6, n) and (6,), and whether the mass matrix of
        the base is positive definite.
    """
    n = len(u)
    right = np.empty((6, n + 1))
    for i in range(6):
        missing = Cv[i] - tau_g[i]
        for j in range(len(vdot)):
            missing += M[i, j] * vdot[j]
        for j in range(n):
            right[i, j] = J_b[j, i]
            missing -= J_b[j, i] * u[j]
        right[i, n] = -missing
    L, positive = cholesky(M[:6, :6])
    if positive:
        forward(L, right)
        backward(L, right)
    G, c = right[:, :n], right[:, n]
    H, g = 2.0 * Q1, np.zeros(n)
    for k in range(6):
        for i in range(n):
            f = 2.0 * Q2 * G[k, i]
            g[i] += f * c[k]
            for j in range(n):
                H[i, j] += f * G[k, j]
    return H, g, G.copy(), c.copy(), positive


@compiled
def line_blocks(
    J: Array, R_WC: Array, sides: NDArray[np.int64], cone: Array, slope: Array
) -> tuple[Array, Array]:
    """Return what the program needs of standing line feet.

    Args:
        J: line-contact Jacobians of both feet, shape (2, 5, nv).
        R_WC: contact frames, shape (2, 3, 3).
        sides: standing feet, shape (n,).
        cone: rows of (18) in the frame of the ground, shape (6, 5).
        slope: of the ground, rise per metre along x and y of the world, shape (2,).

    Returns:
        (J_b, W): base columns of the Jacobians, shape (5 n, 6), and cones with forces in W
        (`world_cone`), shape (n, 6, 5).
    """
    J_b, W = np.empty((5 * len(sides), 6)), np.empty((len(sides), 6, 5))
    for k in range(len(sides)):
        side = sides[k]
        for i in range(5):
            for j in range(6):
                J_b[5 * k + i, j] = J[side, i, j]
        turned_cone(cone, R_WC[side], slope, W[k])
    return J_b, W


@compiled
def cone_rows(W: Array, u: Array) -> tuple[Array, Array]:
    """Return the rows ``A d <= b`` that say ``W_i (u + d)_i <= 0``.

    Args:
        W: cone of each foot, shape (n, r, c).
        u: where the corrections d start from, shape (n, c).

    Returns:
        (A, b): shapes (n r, n c) and (n r,).
    """
    n, r, c = W.shape
    A, b = np.zeros((n * r, n * c)), np.zeros(n * r)
    for k in range(n):
        for i in range(r):
            for j in range(c):
                A[r * k + i, c * k + j] = W[k, i, j]
                b[r * k + i] -= W[k, i, j] * u[k, j]
    return A, b


@compiled
def joint_torque(
    M: Array,
    vdot: Array,
    delta_f: Array,
    Cv: Array,
    tau_g: Array,
    J: Array,
    wrench: Array,
    actuated: NDArray[np.int64],
    limits: Array,
) -> tuple[Array, int]:
    """Return what the joints must give, ``M vdot + Cv - tau_g - sum J_i' w_i``.

    Args:
        M: mass matrix, shape (nv, nv).
        vdot: commanded acceleration, shape (nv,); becomes what can be had.
        delta_f: error of its base part, shape (6,).
        Cv: Coriolis and centrifugal forces, shape (nv,).
        tau_g: gravity forces, shape (nv,).
        J: contact Jacobians of both feet, shape (2, 5, nv).
        wrench: of both feet, zero in the air, shape (2, 5).
        actuated: index of each actuator in v, shape (na,).
        limits: symmetric torque limits [N m], shape (na,).

    Returns:
        (torque, clipped): within the limits, shape (na,), and how many were not.
    """
    for i in range(6):
        vdot[i] += delta_f[i]
    torque, clipped = np.empty(len(actuated)), 0
    for k in range(len(actuated)):
        i = actuated[k]
        s = Cv[i] - tau_g[i]
        for j in range(len(vdot)):
            s += M[i, j] * vdot[j]
        for side in range(2):
            for j in range(5):
                s -= J[side, j, i] * wrench[side, j]
        torque[k] = min(max(s, -limits[k]), limits[k])
        clipped += torque[k] != s
    return torque, clipped
