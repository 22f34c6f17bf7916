"""The linear inverted pendulum and its divergent component of motion (DCM).

With w = sqrt(g / h) the DCM is xi = c + c' / w. It obeys xi' = w (xi - p) for a centre of
pressure p, and the CoM follows it: c' = w (xi - c). All quantities here are horizontal.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.gait import reference_kernels

Array = NDArray[np.float64]

STANDARD_GRAVITY = 9.81  # [m/s^2]


def natural_frequency(com_height: float) -> float:
    """Return w = sqrt(g / h) [1/s] for a CoM `com_height` [m] above the ground.

    Raises:
        ValueError: the height is not positive.
    """
    if not com_height > 0.0:
        raise ValueError(f"CoM height = {com_height}: must be positive")
    return float(np.sqrt(STANDARD_GRAVITY / com_height))


def switch_time(double_support: float, omega: float) -> float:
    """Return when the CoP may jump so that the DCM ends as if it had moved evenly.

    In double support the CoP moves at constant speed from the old to the new foot. The
    DCM at the end is the same as for a CoP that jumps at this time after the start.

    Args:
        double_support: length of the double support [s].
        omega: natural frequency [1/s].

    Returns:
        Time from the start of the double support [s]; near half of it.
    """
    a = omega * double_support
    if a < 1e-9:
        return 0.5 * double_support
    kappa = (np.expm1(a) - a) / a  # w times the integral of exp(w (T - t)) t / T
    return float(double_support - np.log1p(kappa) / omega)


def balancing_cop(xi: Array, xi_goal: Array, omega: float, duration: float) -> Array:
    """Return the resting CoP that takes the DCM from `xi` to `xi_goal` in `duration`.

    Args:
        xi: DCM now [m], shape (2,).
        xi_goal: DCM desired after `duration` [m], shape (2,).
        omega: natural frequency [1/s].
        duration: [s], positive.

    Returns:
        The CoP [m], shape (2,).
    """
    growth = np.exp(omega * duration)
    return (growth * xi - xi_goal) / (growth - 1.0)


@dataclass(frozen=True)
class DcmPiece:
    """A piece of DCM trajectory, xi(t) = centre + amplitude exp(rate (t - start)).

    Attributes:
        start, end: interval [s]; `end` may be infinite.
        centre: [m], shape (2,). For rate = +w it is the CoP.
        amplitude: xi(start) - centre [m], shape (2,).
        rate: +w for a free pendulum, negative for a DCM that is being captured [1/s].
    """

    start: float
    end: float
    centre: Array
    amplitude: Array
    rate: float

    def dcm(self, t: float) -> Array:
        """Return xi(t) [m], shape (2,)."""
        return self.centre + self.amplitude * np.exp(self.rate * (t - self.start))


def follow_dcm(
    com: Array, pieces: Sequence[DcmPiece], times: Array, omega: float
) -> tuple[Array, Array]:
    """Return the CoM that follows a DCM trajectory, c' = w (xi - c), in closed form.

    Args:
        com: CoM at ``pieces[0].start`` [m], shape (2,).
        pieces: consecutive pieces; the last must reach beyond the last time.
        times: increasing times not before the first piece [s], shape (n,).
        omega: natural frequency [1/s].

    Returns:
        (position, velocity) of the CoM at `times`, each of shape (n, 2).
    """
    rows = [(p.start, p.end, *p.centre.tolist(), *p.amplitude.tolist(), p.rate) for p in pieces]
    return reference_kernels.follow_dcm(com, np.array(rows), times, omega)
