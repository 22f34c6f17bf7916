"""Compiled: keeps the joints of a swinging leg off their stops.

A leg that reaches for a place beyond its stops, or stretches its knee, would be asked for ever
larger accelerations: the task of its foot cannot be met there. Near a stop the joint is held off it
instead, and the foot follows its task in the directions in which the other joints can move it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.kernels import orthonormal_rows
from drake_linefoot.wbc.kernels import prioritised

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Flags = NDArray[np.bool_]

_LENGTH = 0.05  # [m] for which a radian of the foot is given up


class Stops(NamedTuple):
    """The stops of both legs, less the margin.

    Attributes:
        index_q: of the joints of each leg in q, shape (2, n).
        index_v: of them in v, shape (2, n).
        lower: [rad], shape (2, n).
        upper: [rad], shape (2, n).
        rate: of the spring that a joint may not be faster than, its natural frequency [1/s].
    """

    index_q: Indices
    index_v: Indices
    lower: Array
    upper: Array
    rate: float


@compiled
def off_stops(
    q: Array, v: Array, a: Array, lower: Array, upper: Array, rate: float
) -> tuple[Array, Flags]:
    """Return the accelerations nearest to wanted ones that keep joints off their stops.

    A joint comes no nearer to a stop than a critically damped spring at the stop lets it.

    Args:
        q: angles [rad], shape (n,).
        v: their rates [rad/s], shape (n,).
        a: wanted accelerations [rad/s^2], shape (n,).
        lower: stops [rad], shape (n,).
        upper: stops [rad], shape (n,).
        rate: of the spring [1/s].

    Returns:
        (allowed, changed): accelerations [rad/s^2], shape (n,), and which differ from what is
        wanted, shape (n,).
    """
    allowed, changed = np.empty(len(a)), np.zeros(len(a), dtype=np.bool_)
    for i in range(len(a)):
        low = rate * (rate * (lower[i] - q[i]) - 2.0 * v[i])
        high = rate * (rate * (upper[i] - q[i]) - 2.0 * v[i])
        allowed[i] = min(max(a[i], low), high)
        changed[i] = allowed[i] != a[i]
    return allowed, changed


@compiled
def held_rows(
    J: Array, b: Array, leg: Indices, held: Flags, a: Array, tolerance: float
) -> tuple[Array, Array]:
    """Return the task of a foot with some joints of its leg held.

    Args:
        J: of the swing foot, three rows of position over two of direction, shape (5, nv).
        b: right side of its task, shape (5,).
        leg: index of the leg's joints in v, shape (n,).
        held: which of them are held, shape (n,).
        a: their accelerations [rad/s^2], of those that are held, shape (n,).
        tolerance: see `prioritised`.

    Returns:
        (J, b): a row for each held joint, then the combinations of the foot's rows that the
        other joints of the leg span; a turn of the foot is given up before its place.
    """
    units, count = np.array([1.0, 1.0, 1.0, _LENGTH, _LENGTH]), int(np.sum(held))
    scaled = np.empty((5, J.shape[1]))
    for i in range(5):
        scaled[i] = units[i] * J[i]
    free, at = np.empty((len(leg) - count, 5)), 0
    rows, right = np.zeros((len(leg), J.shape[1])), np.zeros(len(leg))
    for j in range(len(leg)):
        if held[j]:
            rows[j - at, leg[j]], right[j - at] = 1.0, a[j]
        else:
            free[at] = scaled[:, leg[j]]
            at += 1
    Q, _, kept = orthonormal_rows(free, tolerance)
    end = count
    for i in range(len(free)):
        if kept[i]:
            for k in range(5):
                rows[end] += Q[i, k] * scaled[k]
                right[end] += Q[i, k] * units[k] * b[k]
            end += 1
    return rows[:end], right[:end]


@compiled
def kept_off_stops(
    M: Array,
    q: Array,
    v: Array,
    J: Array,
    b: Array,
    first: int,
    side: int,
    stops: Stops,
    tolerance: float,
) -> tuple[Array, int, bool]:
    """Return the acceleration that meets rows as `prioritised`, with joints off their stops.

    Args:
        M: mass matrix, shape (nv, nv).
        q: positions, shape (nq,).
        v: velocities, shape (nv,).
        J: rows, highest priority first, shape (m, nv).
        b: shape (m,).
        first: of the five rows of the swing foot.
        side: of it.
        stops: of both legs.
        tolerance: see `prioritised`.

    Returns:
        (vdot, dropped, positive) of `prioritised`.
    """
    leg, end = stops.index_v[side], first + 5
    held, a = np.zeros(len(leg), dtype=np.bool_), np.empty(len(leg))
    vdot, dropped, positive = prioritised(M, J, b, tolerance)
    while positive:
        allowed, changed = off_stops(
            q[stops.index_q[side]], v[leg], vdot[leg], stops.lower[side], stops.upper[side],
            stops.rate,
        )  # fmt: skip
        more = False
        for j in range(len(leg)):
            if changed[j] and not held[j]:
                held[j], a[j], more = True, allowed[j], True
        if not more:
            break
        rows, right = held_rows(J[first:end], b[first:end], leg, held, a, tolerance)
        all_rows = np.concatenate((J[:first], rows, J[end:]))
        all_b = np.concatenate((b[:first], right, b[end:]))
        vdot, dropped, positive = prioritised(M, all_rows, all_b, tolerance)
    return vdot, dropped, positive
