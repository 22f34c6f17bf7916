"""Compiled: keeps the joints of the legs off their stops.

A leg that reaches for a place beyond its stops, or stretches its knee, would be asked for ever
larger accelerations: the task of its foot cannot be met there. Near a stop the joint is held off it
instead, and the foot follows its task in the directions in which the other joints can move it.
A standing leg that hits a stop throws the robot up: its knee gives up the height of the CoM, its
ankle lets the foot turn.
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
_KNEE, _ANKLE = 3, 4  # places in a leg
_PITCH = 3  # row of a foot's pitch among its five


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
def hold_more(
    q: Array,
    v: Array,
    vdot: Array,
    contact: tuple[bool, bool],
    swings: bool,
    stops: Stops,
    held: Flags,
    a: Array,
) -> bool:
    """Hold the joints that would come too near to their stops; return whether that is news.

    Of standing legs, ankles are held, and the knee that would come nearer to its stop: one height
    of the CoM can be given up, see `rows_with_held`.

    Args:
        q: positions, shape (nq,).
        v: velocities, shape (nv,).
        vdot: wanted accelerations, shape (nv,).
        contact: whether the left and the right foot stand.
        swings: whether the other foot has a task.
        stops: of both legs.
        held: joints of both legs that are held, shape (2, n); changed in place.
        a: their accelerations [rad/s^2], shape (2, n); changed in place.
    """
    more, knee, worst = False, -1, 0.0
    for side in range(2):
        stands, leg = contact[side], stops.index_v[side]
        if not (stands or swings):
            continue
        allowed, changed = off_stops(
            q[stops.index_q[side]], v[leg], vdot[leg], stops.lower[side], stops.upper[side],
            stops.rate,
        )  # fmt: skip
        for j in range(_KNEE if stands else 0, len(leg)):
            if not changed[j] or held[side, j]:
                continue
            a[side, j] = allowed[j]
            if stands and j == _KNEE:
                excess = abs(allowed[j] - vdot[leg[j]])
                if excess > worst:
                    knee, worst = side, excess
            else:
                held[side, j], more = True, True
    if knee >= 0 and not (contact[1 - knee] and held[1 - knee, _KNEE]):
        held[knee, _KNEE], more = True, True
    return more


@compiled
def rows_with_held(
    J: Array,
    b: Array,
    contact: tuple[bool, bool],
    legs: Indices,
    held: Flags,
    a: Array,
    tolerance: float,
) -> tuple[Array, Array]:
    """Return the rows of all tasks with some joints held, and what they cost.

    The ankle of a standing foot takes the place of the foot's pitch: a foot that turns on an edge
    goes on with its shin. The knee of a standing leg comes before the momentum, of which the
    height of the CoM is left out. A swinging foot has `held_rows`.

    Args:
        J: five rows of each standing foot, six of momentum with the vertical force last, five of
            the swing foot if there is one, the others, shape (m, nv).
        b: shape (m,).
        contact: whether the left and the right foot stand.
        legs: index of the legs' joints in v, shape (2, n).
        held: joints of both legs that are held, shape (2, n).
        a: their accelerations [rad/s^2], shape (2, n).
        tolerance: see `prioritised`.

    Returns:
        (J, b): with at most as many rows.
    """
    J, b, at = J.copy(), b.copy(), 0
    momentum = 5 * (int(contact[0]) + int(contact[1]))
    for side in range(2):
        if not contact[side]:
            continue
        if held[side, _ANKLE]:
            J[at + _PITCH], b[at + _PITCH] = 0.0, a[side, _ANKLE]
            J[at + _PITCH, legs[side, _ANKLE]] = 1.0
        if held[side, _KNEE]:
            for i in range(momentum + 5, momentum, -1):
                J[i], b[i] = J[i - 1], b[i - 1]
            J[momentum], b[momentum] = 0.0, a[side, _KNEE]
            J[momentum, legs[side, _KNEE]] = 1.0
        at += 5
    side = 1 if contact[0] else 0
    if contact[side] or not np.any(held[side]):
        return J, b
    first, end = momentum + 6, momentum + 11
    rows, right = held_rows(J[first:end], b[first:end], legs[side], held[side], a[side], tolerance)
    return (
        np.concatenate((J[:first], rows, J[end:])),
        np.concatenate((b[:first], right, b[end:])),
    )


@compiled
def kept_off_stops(
    M: Array,
    q: Array,
    v: Array,
    J: Array,
    b: Array,
    contact: tuple[bool, bool],
    swings: bool,
    stops: Stops,
    tolerance: float,
) -> tuple[Array, int, bool]:
    """Return the acceleration that meets rows as `prioritised`, with joints off their stops.

    Args:
        M: mass matrix, shape (nv, nv).
        q: positions, shape (nq,).
        v: velocities, shape (nv,).
        J: rows, see `rows_with_held`, shape (m, nv).
        b: shape (m,).
        contact: whether the left and the right foot stand.
        swings: whether J has rows of a swing foot.
        stops: of both legs.
        tolerance: see `prioritised`.

    Returns:
        (vdot, dropped, positive) of `prioritised`.
    """
    legs = stops.index_v
    held, a = np.zeros(legs.shape, dtype=np.bool_), np.zeros(legs.shape)
    vdot, dropped, positive = prioritised(M, J, b, tolerance)
    while positive and hold_more(q, v, vdot, contact, swings, stops, held, a):
        rows, right = rows_with_held(J, b, contact, legs, held, a, tolerance)
        vdot, dropped, positive = prioritised(M, rows, right, tolerance)
    return vdot, dropped, positive
