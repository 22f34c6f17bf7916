"""Zero-order-hold discretisation of affine time-varying systems."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.math import discretisation_kernels as kernels

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
    return kernels.zero_order_hold(A, B, c, dt, order)
