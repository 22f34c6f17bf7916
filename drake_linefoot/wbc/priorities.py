"""Strictly prioritised accelerations: one QR factorisation in the metric of the mass matrix.

A task asks for ``J vdot = b``. Tasks are ordered; each is met as well as the ones above
leave room for, in the dynamically consistent sense of [5], [30]: with M = L L' and
z = L' vdot, the recursion of null-space projections equals a forward substitution on the
QR factorisation of the stacked ``J L^-T`` as long as the stack has full row rank.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

Array = NDArray[np.float64]

RANK_TOLERANCE = 1e-5  # [-] of a row's norm in the metric of M^-1
_BLOCK = 32  # of LAPACK's workspace


@dataclass(frozen=True)
class TaskRows:
    """A task ``J vdot = b``.

    Attributes:
        J: Jacobian, shape (m, nv).
        b: desired acceleration minus the bias Jdot v, shape (m,).
    """

    J: Array
    b: Array


def prioritised_acceleration(M: Array, tasks: Sequence[TaskRows]) -> tuple[Array, int]:
    """Return the acceleration that meets the tasks in strict order.

    Where tasks leave freedom, the acceleration is the one of least ``vdot' M vdot``. A row
    that depends on the rows above it is dropped.

    Args:
        M: mass matrix, shape (nv, nv).
        tasks: highest priority first.

    Returns:
        (vdot, dropped): shape (nv,), and the number of dropped rows.
    """
    J = np.concatenate([t.J for t in tasks])
    b = np.concatenate([t.b for t in tasks])
    L = _checked(lapack.dpotrf(M, lower=1))[0]
    J_hat_T = _checked(lapack.dtrtrs(L, J.T, lower=1))[0]
    norms = np.sqrt(np.einsum("ij,ij->j", J_hat_T, J_hat_T))
    z, dropped = _by_factorisation(J_hat_T, b, norms), 0
    if z is None:
        z, dropped = _row_by_row(J_hat_T.T, b, norms)
    return np.asarray(_checked(lapack.dtrtrs(L, z, lower=1, trans=1))[0]), dropped


def _by_factorisation(J_hat_T: Array, b: Array, norms: Array) -> Array | None:
    """Return the least z with ``J_hat z = b``; None when its rows are not independent."""
    n, m = J_hat_T.shape
    if m > n:
        return None
    QR, tau, _, _ = lapack.dgeqrf(J_hat_T, lwork=_BLOCK * m)
    if (np.abs(np.diagonal(QR)) <= RANK_TOLERANCE * norms).any():
        return None
    y = np.zeros((n, 1))
    y[:m, 0] = _checked(lapack.dtrtrs(QR[:m], b, trans=1))[0]
    return np.asarray(lapack.dormqr("L", "N", QR, tau, y, _BLOCK)[0][:, 0])


def _checked(result: tuple[Any, ...]) -> tuple[Any, ...]:
    """Return what LAPACK returned; raise when it says that the matrix is of no use."""
    if result[-1]:
        raise np.linalg.LinAlgError(f"LAPACK: {result[-1]}: the mass matrix is not positive")
    return result


def _row_by_row(J_hat: Array, b: Array, norms: Array) -> tuple[Array, int]:
    """Meet one row after the other, dropping those that depend on rows above.

    Gram-Schmidt, twice for accuracy; slower than one QR but it says which row fails.
    """
    z = np.zeros(J_hat.shape[1])
    basis: list[Array] = []
    dropped = 0
    for row, target, norm in zip(J_hat, b, norms, strict=True):
        left = row.copy()
        for _ in range(2):
            for q in basis:
                left -= (q @ left) * q
        length = float(np.linalg.norm(left))
        if length <= RANK_TOLERANCE * norm:
            dropped += 1
            continue
        z = z + left * ((target - row @ z) / length**2)
        basis.append(left / length)
    return z, dropped


def recursive_acceleration(M: Array, tasks: Sequence[TaskRows]) -> Array:
    """Return the same acceleration by the textbook recursion of null-space projections.

    Slow and obvious; kept to compare `prioritised_acceleration` with. For each task,
    ``vdot += Jbar (b - J vdot)`` with Jbar the dynamically consistent pseudoinverse of the
    task projected into the null space of all tasks above, ``N -= Jbar J N``.

    Args:
        M: mass matrix, shape (nv, nv).
        tasks: highest priority first.

    Returns:
        Shape (nv,).
    """
    n = len(M)
    M_inv = np.linalg.inv(M)
    vdot = np.zeros(n)
    N = np.eye(n)
    for task in tasks:
        JN = task.J @ N
        Lambda = np.linalg.pinv(JN @ M_inv @ JN.T, rcond=RANK_TOLERANCE**2)
        Jbar = M_inv @ JN.T @ Lambda
        vdot = vdot + Jbar @ (task.b - task.J @ vdot)
        N = N @ (np.eye(n) - Jbar @ JN)
    return vdot
