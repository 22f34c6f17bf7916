"""Strictly prioritised accelerations: orthonormal rows in the metric of the mass matrix.

A task asks for ``J vdot = b``. Tasks are ordered; each is met as well as the ones above
leave room for, in the dynamically consistent sense of [5], [30]: with M = L L' and
z = L' vdot, the recursion of null-space projections equals a forward substitution on the
rows of the stacked ``J L^-T``, made orthonormal from the highest priority down.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.wbc.kernels import prioritised

Array = NDArray[np.float64]

RANK_TOLERANCE = 1e-5  # [-] of a row's norm in the metric of M^-1


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

    Raises:
        numpy.linalg.LinAlgError: the mass matrix is not positive definite.
    """
    J = np.concatenate([t.J for t in tasks])
    b = np.concatenate([t.b for t in tasks])
    vdot, dropped, positive = prioritised(M, J, b, RANK_TOLERANCE)
    if not positive:
        raise np.linalg.LinAlgError("the mass matrix is not positive definite")
    return vdot, dropped


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
