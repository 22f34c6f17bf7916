"""Keeps the joints of the legs off their stops.

A leg that reaches for a place beyond its stops, or stretches its knee, would be asked for ever
larger accelerations: the task of its foot cannot be met there. Near a stop the joint is held off it
instead, and the foot follows its task in the directions in which the other joints can move it.
A standing leg that hits a stop throws the robot up: its knee gives up the height of the CoM, its
ankle lets the foot turn.
"""

from typing import NamedTuple

import numpy as np

from drake_linefoot.math.compiled import compiled, inlined
from drake_linefoot.math.linear import orthonormal_rows
from drake_linefoot.signals import RobotDynamics
from drake_linefoot.types import Array, Flags, Indices
from drake_linefoot.wbc.priorities import RANK_TOLERANCE, prioritised_acceleration
from drake_linefoot.wbc.tasks import TaskRows, put, swing_side

_PITCH = 3  # row of a foot's pitch among its five


class Stops(NamedTuple):
    """The stops of both legs, less the margin.

    Attributes:
        index_q: of the joints of each leg in q, shape (2, n).
        index_v: of them in v, shape (2, n).
        lower: [rad], shape (2, n).
        upper: [rad], shape (2, n).
        rate: of the spring that a joint may not be faster than, its natural frequency [1/s].
        pitch_length: for which a radian of a foot is given up [m].
    """

    index_q: Indices
    index_v: Indices
    lower: Array
    upper: Array
    rate: float
    pitch_length: float


@compiled
def off_stops(
    q: Array, v: Array, a: Array, lower: Array, upper: Array, rate: float
) -> tuple[Array, Flags]:
    """Return the accelerations nearest to desired ones that keep joints off their stops.

    A joint comes no nearer to a stop than a critically damped spring at the stop lets it.

    Args:
        q: angles [rad], shape (n,).
        v: their rates [rad/s], shape (n,).
        a: desired accelerations [rad/s^2], shape (n,).
        lower: stops [rad], shape (n,).
        upper: stops [rad], shape (n,).
        rate: of the spring [1/s].

    Returns:
        (allowed, changed): accelerations [rad/s^2], shape (n,), and which differ from what is
        desired, shape (n,).
    """
    allowed, changed = np.empty(len(a)), np.zeros(len(a), dtype=np.bool_)
    for i in range(len(a)):
        low = rate * (rate * (lower[i] - q[i]) - 2.0 * v[i])
        high = rate * (rate * (upper[i] - q[i]) - 2.0 * v[i])
        allowed[i] = min(max(a[i], low), high)
        changed[i] = allowed[i] != a[i]
    return allowed, changed


@compiled
def held_rows(task: TaskRows, leg: Indices, held: Flags, a: Array, pitch_length: float) -> TaskRows:
    """Return the task of a foot with some joints of its leg held.

    Args:
        task: of the swing foot, three rows of position over two of direction.
        leg: index of the leg's joints in v, shape (n,).
        held: which of them are held, shape (n,).
        a: their accelerations [rad/s^2], of those that are held, shape (n,).
        pitch_length: for which a radian of the foot is given up [m].

    Returns:
        A row for each held joint, then the combinations of the foot's rows that the
        other joints of the leg span; a turn of the foot is given up before its place.
    """
    units, count = np.array([1.0, 1.0, 1.0, pitch_length, pitch_length]), int(np.sum(held))
    scaled = np.empty(task.J.shape)
    for i in range(5):
        scaled[i] = units[i] * task.J[i]
    free, at = np.empty((len(leg) - count, 5)), 0
    rows, right = np.zeros((len(leg), task.J.shape[1])), np.zeros(len(leg))
    for j in range(len(leg)):
        if held[j]:
            rows[j - at, leg[j]], right[j - at] = 1.0, a[j]
        else:
            free[at] = scaled[:, leg[j]]
            at += 1
    Q, _, kept = orthonormal_rows(free, RANK_TOLERANCE)
    end = count
    for i in range(len(free)):
        if kept[i]:
            for k in range(5):
                rows[end] += Q[i, k] * scaled[k]
                right[end] += Q[i, k] * units[k] * task.b[k]
            end += 1
    return TaskRows(rows[:end], right[:end])


@compiled
def hold_more(
    d: RobotDynamics,
    vdot: Array,
    contact: tuple[bool, bool],
    swings: bool,
    stops: Stops,
    held: Flags,
    a: Array,
) -> bool:
    """Hold the joints that would come too near to their stops; return whether that is news.

    Of standing legs, ankles are held, and the knee that would come nearer to its stop: one height
    of the CoM can be given up, see `rows_with_held`. Knees come first: beside a straight one, other
    joints are asked for what they are not asked for any more when it is held.

    Args:
        d: present quantities.
        vdot: desired accelerations, shape (nv,).
        contact: whether the left and the right foot stand.
        swings: whether the other foot has a task.
        stops: of both legs.
        held: joints of both legs that are held, shape (2, n); changed in place.
        a: their accelerations [rad/s^2], shape (2, n); changed in place.
    """
    knee, allowed, news = len(held[0]) - 2, np.empty(held.shape), np.zeros_like(held)
    for side in range(2):
        if contact[side] or swings:
            leg = stops.index_v[side]
            allowed[side], changed = off_stops(
                d.q[stops.index_q[side]], d.v[leg], vdot[leg], stops.lower[side],
                stops.upper[side], stops.rate,
            )  # fmt: skip
            first = knee if contact[side] else 0
            news[side, first:] = changed[first:] & ~held[side, first:]
    bent, worst, more = -1, 0.0, False
    for side in range(2):
        if news[side, knee]:
            a[side, knee] = allowed[side, knee]
            excess = abs(allowed[side, knee] - vdot[stops.index_v[side, knee]])
            if not contact[side]:
                held[side, knee], more = True, True
            elif excess > worst:
                bent, worst = side, excess
    if bent >= 0 and not (contact[1 - bent] and held[1 - bent, knee]):
        held[bent, knee], more = True, True
    if more:
        return True
    for side in range(2):
        for j in range(len(held[0])):
            if news[side, j] and j != knee:
                a[side, j], held[side, j], more = allowed[side, j], True, True
    return more


@inlined
def rows_with_held(
    tasks: TaskRows, contact: tuple[bool, bool], stops: Stops, held: Flags, a: Array
) -> TaskRows:
    """Return the rows of all tasks with some joints held, and what they cost.

    The ankle of a standing foot takes the place of the foot's pitch: a foot that turns on an edge
    goes on with its shin. The knee of a standing leg comes before the momentum, of which the
    height of the CoM is left out. A swinging foot has `held_rows`.

    Args:
        tasks: see `stacked_tasks`; of the momentum the vertical force is last.
        contact: whether the left and the right foot stand.
        stops: of both legs.
        held: joints of both legs that are held, shape (2, n).
        a: their accelerations [rad/s^2], shape (2, n).

    Returns:
        At most as many rows.
    """
    J, b, at = tasks.J.copy(), tasks.b.copy(), 0
    legs, knee, ankle = stops.index_v, len(held[0]) - 2, len(held[0]) - 1
    momentum = 5 * (int(contact[0]) + int(contact[1]))
    for side in range(2):
        if not contact[side]:
            continue
        if held[side, ankle]:
            J[at + _PITCH], b[at + _PITCH] = 0.0, a[side, ankle]
            J[at + _PITCH, legs[side, ankle]] = 1.0
        if held[side, knee]:
            for i in range(momentum + 5, momentum, -1):
                J[i], b[i] = J[i - 1], b[i - 1]
            J[momentum], b[momentum] = 0.0, a[side, knee]
            J[momentum, legs[side, knee]] = 1.0
        at += 5
    side = swing_side(contact)
    if contact[side] or not np.any(held[side]):
        return TaskRows(J, b)
    first, end = momentum + 6, momentum + 11
    task, length = TaskRows(J[first:end], b[first:end]), stops.pitch_length
    foot = held_rows(task, legs[side], held[side], a[side], length)
    size = len(b) - len(task.b) + len(foot.b)
    rows = TaskRows(np.empty((size, J.shape[1])), np.empty(size))
    left = put(foot, put(TaskRows(J[:first], b[:first]), rows))
    put(TaskRows(J[end:], b[end:]), left)
    return rows


@inlined
def kept_off_stops(
    d: RobotDynamics, tasks: TaskRows, contact: tuple[bool, bool], swings: bool, stops: Stops
) -> tuple[Array, int, bool]:
    """Return the acceleration that meets tasks in strict order, with joints off their stops.

    Args:
        d: present quantities.
        tasks: see `stacked_tasks`.
        contact: whether the left and the right foot stand.
        swings: whether there are rows of a swing foot.
        stops: of both legs.

    Returns:
        (vdot, dropped, positive) of `prioritised_acceleration`.
    """
    rows, shape = tasks, stops.index_v.shape
    held, a = np.zeros(shape, dtype=np.bool_), np.zeros(shape)
    while True:
        vdot, dropped, positive = prioritised_acceleration(d.M, rows.J, rows.b)
        if not (positive and hold_more(d, vdot, contact, swings, stops, held, a)):
            return vdot, dropped, positive
        rows = rows_with_held(tasks, contact, stops, held, a)
