"""Compiled: where the DCM of the linear inverted pendulum is, goes and has to be.

See `drake_linefoot.gait.pendulum`.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.math.compiled import compiled

Array = NDArray[np.float64]


@compiled
def dcm(com: Array, com_velocity: Array, omega: float) -> Array:
    """Return the DCM ``c + c' / w``.

    Args:
        com: CoM [m], shape (2,) or, with a height that is left out, (3,).
        com_velocity: its velocity [m/s], shaped likewise.
        omega: natural frequency [1/s].

    Returns:
        [m], shape (2,).
    """
    return com[:2] + com_velocity[:2] / omega


@compiled
def propagate_dcm(xi: Array, cop: Array, omega: float, duration: float) -> Array:
    """Return the DCM after `duration` [s] with the CoP at rest.

    Args:
        xi: DCM [m], shape (2,).
        cop: centre of pressure [m], shape (2,).
        omega: natural frequency [1/s].
        duration: [s].

    Returns:
        p + (xi - p) exp(w t), shape (2,).
    """
    return cop + (xi - cop) * math.exp(omega * duration)


@compiled
def propagate_com(
    com: Array, com_velocity: Array, cop: Array, omega: float, duration: float
) -> Array:
    """Return the CoM after `duration` [s] with the CoP at rest.

    Args:
        com: CoM [m], shape (2,) or, with a height that is left out, (3,).
        com_velocity: its velocity [m/s], shaped likewise.
        cop: centre of pressure [m], shape (2,).
        omega: natural frequency [1/s].
        duration: [s].

    Returns:
        p + (c - p) cosh(w t) + c' / w sinh(w t), shape (2,).
    """
    grow = math.exp(omega * duration)
    falls, flies = 0.5 * (grow + 1.0 / grow), 0.5 * (grow - 1.0 / grow) / omega
    return cop + falls * (com[:2] - cop) + flies * com_velocity[:2]


@compiled
def dcm_offset(strides: Array, omega: float, step_duration: float) -> Array:
    """Return where the DCM has to be, relative to a foot, when the weight comes onto it.

    The only offset from which the planned strides never diverge:
    ``b = sum_j exp(-w T (j + 1)) s_j``, with the last stride repeated with alternating
    lateral sign being far enough away to be left out.

    Args:
        strides: displacements from each foothold to the next [m], shape (n, 2); the
            first leaves the foot in question.
        omega: natural frequency [1/s].
        step_duration: T, from one switch of the CoP to the next [s].

    Returns:
        xi - p at the switch [m], shape (2,).
    """
    offset = np.zeros(2)
    for j in range(len(strides)):
        decay = math.exp(-omega * step_duration * (j + 1))
        offset[0] += decay * strides[j, 0]
        offset[1] += decay * strides[j, 1]
    return offset
