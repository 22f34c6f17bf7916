"""How accurate a solution is, and the loosest setting of a solver that is accurate enough."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.benchmark.solvers import Prepare
from drake_linefoot.mpc.condensed_qp import CondensedQp

Array = NDArray[np.float64]

LARGEST_ERROR = 1.0  # [N] that a solver may leave in the first wrench


@dataclass(frozen=True)
class Target:
    """A program and its solution.

    Attributes:
        qp: the program.
        z: its solution in scaled variables, shape (5 n,).
    """

    qp: CondensedQp
    z: Array


@dataclass(frozen=True)
class Setting:
    """What a search for a tolerance came to.

    Attributes:
        tolerance: the loosest that will do; None when none does.
        error: largest error over all programs [N], at that tolerance or at the best one;
            infinite when no tolerance solved all of them.
    """

    tolerance: float | None
    error: float


def first_wrench_error(target: Target, z: Array | None, half_length: float) -> float:
    """Return the largest error in the wrenches of the first interval [N].

    Torques count as the force at the end of the contact line that makes them.

    Args:
        target: program and solution.
        z: what a solver says, shape (5 n,); None when it failed.
        half_length: of the contact line [m].
    """
    if z is None or z.shape != target.z.shape or not np.isfinite(z).all():
        return float("inf")
    difference = (target.qp.scale * (z - target.z)).reshape(-1, 5)
    first = np.abs(difference[target.qp.active[:, 0] == 0])
    first[:, 3:] /= half_length
    return float(first.max(initial=0.0))


def loosest(
    prepare: Prepare, targets: Sequence[Target], tolerances: Sequence[float], half_length: float
) -> Setting:
    """Return the loosest tolerance at which every program is solved to `LARGEST_ERROR`.

    Args:
        prepare: of the solver, see `solvers.Solver`.
        targets: programs with their solutions.
        tolerances: to try, loosest first.
        half_length: of the contact line [m].
    """
    best = float("inf")
    for tolerance in tolerances:
        worst = 0.0
        for target in targets:
            error = first_wrench_error(target, prepare(target.qp, tolerance)(), half_length)
            worst = max(worst, error)
            if not np.isfinite(worst):
                break
        if worst <= LARGEST_ERROR:
            return Setting(tolerance, worst)
        best = min(best, worst)
    return Setting(None, best)
