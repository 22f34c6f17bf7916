"""Keeps the joints of the legs off their limits.

A leg that reaches for a place beyond its limits, or stretches its knee, would be asked for ever
larger accelerations: the task of its foot cannot be met there. A limit is active where a joint
would come too near; the joint is held off it, and the foot follows its task in the directions in
which the other joints can move it. A standing leg that hits a limit throws the robot up: its knee
gives up the height of the CoM, its ankle lets the foot turn. Joints of a swinging leg keep to their
torques likewise, see `hold_weak_joints`.
"""

import numpy as np

from drake_linefoot.axes import TAU_X, TAU_Y
from drake_linefoot.math.compiled import compiled, inlined
from drake_linefoot.math.linear import orthonormal_rows
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.knee_range import knee_range
from drake_linefoot.robot.legs import leg_roles, read_legs
from drake_linefoot.signals import RobotDynamics
from drake_linefoot.types import Array, Flags, Indices
from drake_linefoot.wbc.held_joints import (
    WEAK_PASSES,
    JointLimits,
    hold_weak_joints,
    limited_acceleration,
)
from drake_linefoot.wbc.parameters import WbcParameters
from drake_linefoot.wbc.priorities import RANK_TOLERANCE, prioritised_acceleration
from drake_linefoot.wbc.tasks.stack import Places
from drake_linefoot.wbc.tasks.task import TaskRows


@compiled
def rows_at_limits(
    task: TaskRows, leg: Indices, active: Flags, a: Array, pitch_length: float
) -> TaskRows:
    """Return the task of a swinging foot with some limits of its leg active.

    Args:
        task: of the foot, three rows of position over those of direction.
        leg: index of the leg's joints in v, shape (n,).
        active: which of them are held off a limit, shape (n,).
        a: their accelerations [rad/s^2], of those that are held, shape (n,).
        pitch_length: for which a radian of the foot is given up [m].

    Returns:
        A row for each joint that is held, then the combinations of the foot's rows that the
        other joints of the leg span; a turn of the foot is given up before its place.
    """
    m, count = len(task.b), int(np.sum(active))
    units, scaled = np.ones(m), np.empty(task.J.shape)
    units[3:] = pitch_length
    for i in range(m):
        scaled[i] = units[i] * task.J[i]
    free, at = np.empty((len(leg) - count, m)), 0
    rows, right = np.zeros((len(leg), task.J.shape[1])), np.zeros(len(leg))
    for j in range(len(leg)):
        if active[j]:
            rows[j - at, leg[j]], right[j - at] = 1.0, a[j]
        else:
            free[at] = scaled[:, leg[j]]
            at += 1
    Q, _, kept = orthonormal_rows(free, RANK_TOLERANCE)
    end = count
    for i in range(len(free)):
        if kept[i]:
            for k in range(m):
                rows[end] += Q[i, k] * scaled[k]
                right[end] += Q[i, k] * units[k] * task.b[k]
            end += 1
    return TaskRows(rows[:end], right[:end])


@compiled
def activate_limits(
    d: RobotDynamics,
    vdot: Array,
    contact: tuple[bool, bool],
    swings: tuple[bool, bool],
    limits: JointLimits,
    active: Flags,
    a: Array,
) -> bool:
    """Hold the joints that would come too near to their limits; return whether that is news.

    Of standing legs, ankles are held, and the knee that would come nearer to its limit: one height
    of the CoM can be given up, see `stack_at_limits`. Knees come first: beside a straight one,
    other joints are asked for what they are not asked for any more when it is held.

    Args:
        d: present quantities.
        vdot: desired accelerations, shape (nv,).
        contact: whether the left and the right foot stand.
        swings: whether they have a task in the air.
        limits: of both legs.
        active: joints of both legs that are held, shape (2, n); changed in place.
        a: their accelerations [rad/s^2], shape (2, n); changed in place.
    """
    knee, allowed, news = limits.knee, np.empty(active.shape), np.zeros_like(active)
    for side in range(2):
        if contact[side] or swings[side]:
            leg = limits.index_v[side]
            allowed[side], changed = limited_acceleration(
                d.q[limits.index_q[side]], d.v[leg], vdot[leg], limits.lower[side],
                limits.upper[side], limits.rate,
            )  # fmt: skip
            first = knee if contact[side] else 0
            news[side, first:] = changed[first:] & ~active[side, first:]
    bent, worst, more = -1, 0.0, False
    for side in range(2):
        if news[side, knee]:
            a[side, knee] = allowed[side, knee]
            excess = abs(allowed[side, knee] - vdot[limits.index_v[side, knee]])
            if not contact[side]:
                active[side, knee], more = True, True
            elif excess > worst:
                bent, worst = side, excess
    if bent >= 0 and not (contact[1 - bent] and active[1 - bent, knee]):
        active[bent, knee], more = True, True
    if more:
        return True
    for side in range(2):
        for j in range(len(active[0])):
            if news[side, j] and j != knee:
                a[side, j], active[side, j], more = allowed[side, j], True, True
    return more


@compiled
def stack_at_limits(
    tasks: TaskRows, places: Places, limits: JointLimits, active: Flags, a: Array
) -> TaskRows:
    """Return the rows of all tasks with some limits active, and what they cost.

    The ankle of a standing foot takes the place of the foot's pitch, and of a sole's roll: a foot
    that turns on an edge goes on with its shin. The knee of a standing leg comes before the
    momentum, of which the height of the CoM is left out. A swinging foot has `rows_at_limits`.

    Args:
        tasks: see `stacked_tasks`; of the momentum the vertical force is last.
        places: whose rows are whose.
        limits: of both legs.
        active: joints of both legs that are held, shape (2, n).
        a: their accelerations [rad/s^2], shape (2, n).

    Returns:
        At most as many rows.
    """
    J, b, end = tasks.J.copy(), tasks.b.copy(), len(tasks.b)
    legs, knee, ankle, momentum = limits.index_v, limits.knee, limits.ankle, places.momentum
    for side in range(2):
        if places.contact[side] < 0:
            continue
        for joint, row in ((ankle, TAU_Y), (limits.roll, TAU_X)):
            if joint >= 0 and active[side, joint]:
                turn = places.contact[side] + row
                J[turn], b[turn] = 0.0, a[side, joint]
                J[turn, legs[side, joint]] = 1.0
        if active[side, knee]:
            for i in range(momentum + 5, momentum, -1):
                J[i], b[i] = J[i - 1], b[i - 1]
            J[momentum], b[momentum] = 0.0, a[side, knee]
            J[momentum, legs[side, knee]] = 1.0
    less = 0  # rows that swinging feet gave up so far
    for side in range(2):
        first, m = places.swing[side] - less, places.foot
        if places.swing[side] < 0 or not np.any(active[side]):
            continue
        task = TaskRows(J[first : first + m].copy(), b[first : first + m].copy())
        foot = rows_at_limits(task, legs[side], active[side], a[side], limits.pitch_length)
        n = len(foot.b)
        J[first : first + n], b[first : first + n] = foot.J, foot.b
        for i in range(first + m, end):
            J[i - m + n], b[i - m + n] = J[i], b[i]
        end, less = end - m + n, less + m - n
    return TaskRows(J[:end], b[:end])


def leg_limits(humanoid: Humanoid, parameters: WbcParameters) -> JointLimits:
    """Return the limits of both legs, with the margin and the rate of the parameters.

    A knee that could be bent beyond the straight leg ends there: no foot follows its task through
    it.
    """
    lower, upper = np.full(humanoid.nq, -np.inf), np.full(humanoid.nq, np.inf)
    lower[humanoid.actuated_q] = humanoid.position_lower
    upper[humanoid.actuated_q] = humanoid.position_upper
    legs, p, roles = humanoid.leg_q, parameters, leg_roles(humanoid)
    chains = read_legs(humanoid)
    for side in range(2):
        q, knee = humanoid.q_nominal[legs[side]], legs[side, roles.knee]
        lower[knee], upper[knee] = knee_range(chains, side, q, roles.knee)
    lower, upper = lower + p.joint_limit_margin, upper - p.joint_limit_margin
    numbers = float(p.joint_limit_rate), float(p.pitch_length), *roles
    effort = humanoid.effort_limits[humanoid.leg_joints]
    return JointLimits(legs, humanoid.leg_v, lower[legs], upper[legs], *numbers, effort)


@inlined
def acceleration_within_limits(
    d: RobotDynamics,
    tasks: TaskRows,
    places: Places,
    feet: tuple[tuple[bool, bool], tuple[bool, bool]],
    limits: JointLimits,
) -> tuple[Array, int, bool]:
    """Return the acceleration that meets tasks in strict order, with joints off their limits.

    Args:
        d: present quantities.
        tasks: see `stacked_tasks`.
        places: whose rows are whose.
        feet: whether the left and the right foot stand, and whether they swing.
        limits: of both legs.

    Returns:
        (vdot, dropped, positive) of `prioritised_acceleration`.
    """
    (contact, swings), shape = feet, limits.index_v.shape
    rows, active, a = tasks, np.zeros(shape, dtype=np.bool_), np.zeros(shape)
    weak, passes = np.zeros(shape, dtype=np.bool_), 0
    while True:
        vdot, dropped, positive = prioritised_acceleration(d.M, rows.J, rows.b)
        if not positive:
            return vdot, dropped, positive
        if not activate_limits(d, vdot, contact, swings, limits, active, a):
            passes += 1
            held = (active, weak, a)
            if passes > WEAK_PASSES or not hold_weak_joints(d, vdot, swings, limits, held):
                return vdot, dropped, positive
        rows = stack_at_limits(tasks, places, limits, active, a)
