"""Zero-order-hold discretisation of affine time-varying systems, and condensing."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def zero_order_hold(
    A: Array, B: Array, c: Array, dt: Array, order: int = 6
) -> tuple[Array, Array, Array]:
    """Discretise ``x' = A x + B u + c`` over steps of length `dt`, (43).

    The exponential series is cut after `order` terms. The centroidal rows of the ECD
    matrix are nilpotent, so they are exact from order 3 on; the rows of eta keep an
    error of order ``(|A| dt)^(order + 1)``.

    Args:
        A: system matrices, shape (K, n, n) [1/s].
        B: input matrices, shape (K, n, m).
        c: affine terms, shape (K, n).
        dt: step lengths [s], shape (K,).
        order: number of terms of the series, at least 1 (1 is explicit Euler).

    Returns:
        (Ad, Bd, cd) with ``x[k+1] = Ad[k] x[k] + Bd[k] u[k] + cd[k]``, same shapes.

    Raises:
        ValueError: `order` is below 1.
    """
    if order < 1:
        raise ValueError(f"order = {order}: must be at least 1")
    n = A.shape[-1]
    h = np.asarray(dt, dtype=float)[:, None, None]
    eye = np.eye(n)
    # G = dt (I + A dt / 2 (I + A dt / 3 (I + ...))), then Ad = I + A G.
    G = np.broadcast_to(eye, A.shape)
    Ah = A * h
    for k in range(order, 1, -1):
        G = eye + (Ah @ G) / k
    G = G * h
    return eye + A @ G, G @ B, (G @ c[..., None])[..., 0]


def condense(Ad: Array, Bd: Array, cd: Array) -> tuple[Array, Array, Array]:
    """Eliminate the states, ``X = A_qp x0 + B_qp U + C_qp``, (44).

    Args:
        Ad: discrete system matrices, shape (K, n, n).
        Bd: discrete input matrices, shape (K, n, m).
        cd: discrete affine terms, shape (K, n).

    Returns:
        (A_qp, B_qp, C_qp) of shapes (K, n, n), (K, n, K, m) and (K, n): block row k
        gives x[k+1].
    """
    K, n, m = Bd.shape
    A_qp = np.empty((K, n, n))
    B_qp = np.zeros((K, n, K, m))
    C_qp = np.empty((K, n))
    A_qp[0], C_qp[0] = Ad[0], cd[0]
    B_qp[0, :, 0] = Bd[0]
    flat = B_qp.reshape(K, n, K * m)
    for k in range(1, K):
        A_qp[k] = Ad[k] @ A_qp[k - 1]
        C_qp[k] = Ad[k] @ C_qp[k - 1] + cd[k]
        np.matmul(Ad[k], flat[k - 1, :, : k * m], out=flat[k, :, : k * m])
        B_qp[k, :, k] = Bd[k]
    return A_qp, B_qp, C_qp
