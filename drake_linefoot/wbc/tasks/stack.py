"""All tasks of a tick, one below the other in the order of priority; whose rows are whose."""

from typing import NamedTuple

import numpy as np

from drake_linefoot.centroidal import PlanSample
from drake_linefoot.math.compiled import compiled, inlined
from drake_linefoot.signals import RobotDynamics, SwingTarget
from drake_linefoot.types import Array
from drake_linefoot.wbc.tasks.contact import contact_task
from drake_linefoot.wbc.tasks.momentum import momentum_task
from drake_linefoot.wbc.tasks.posture import Joints, joint_task
from drake_linefoot.wbc.tasks.swing import swing_task
from drake_linefoot.wbc.tasks.task import CONTACT, MOMENTUM, POSTURE, SWING, Gains, TaskRows


class Places(NamedTuple):
    """Where the rows of each task begin in the stack; -1 where it has none.

    Attributes:
        contact: of each standing foot.
        momentum: of its six rows, angular over linear.
        swing: of each swinging foot.
        posture: of the joints that are held.
        foot: how many rows a foot has.
    """

    contact: tuple[int, int]
    momentum: int
    swing: tuple[int, int]
    posture: int
    foot: int


@compiled
def put(task: TaskRows, rows: TaskRows, at: int) -> int:
    """Write a task into the stack from row `at`; return the row after it."""
    end = at + len(task.b)
    rows.J[at:end], rows.b[at:end] = task.J, task.b
    return end


@compiled
def put_own(own: Array, first: int, priority: float, rows: TaskRows, at: int) -> tuple[int, int]:
    """Write one's own rows that come before a priority, from row `at`.

    Args:
        own: see `own_rows`, shape (m, nv + 2).
        first: row of them that is next.
        priority: of the task that follows.
        rows: the stack, written.
        at: row of it that is next.

    Returns:
        The next row of `own` and of the stack.
    """
    nv = own.shape[1] - 2
    while first < len(own) and own[first, nv + 1] < priority:
        rows.J[at], rows.b[at] = own[first, :nv], own[first, nv]
        first, at = first + 1, at + 1
    return first, at


@inlined
def stacked_tasks(
    d: RobotDynamics,
    feet: tuple[tuple[bool, bool], tuple[bool, bool], Array, Array],
    plan: PlanSample,
    mass: float,
    gains: Gains,
    arms: tuple[Joints, Array],
    own: Array,
) -> tuple[TaskRows, Places]:
    """Return all tasks of a tick in the order of priority, and where each begins.

    Standing feet, left before right; momentum; swinging feet; the arms; one's own in between.

    Args:
        d: present quantities.
        feet: whether the left and the right foot stand; whether they swing; rows of their
            `SwingTarget`s, shape (2, 6, 3); the slopes of the ground, shape (2, 2).
        plan: the centroidal plan now.
        mass: [kg].
        gains: of all tasks.
        arms: the joints that are held or swing; `GaitTargets.arms`, shape (3,).
        own: see `own_rows`, shape (m, nv + 2).
    """
    contact, swings, target, slopes = feet
    nw, feet_rows = d.J.shape[1], 0
    for side in range(2):
        feet_rows += int(contact[side]) + int(swings[side])
    size = nw * feet_rows + 6 + len(arms[0].q_d) + len(own)
    rows = TaskRows(np.empty((size, len(d.v))), np.empty(size))
    stand, swing = np.full(2, -1), np.full(2, -1)
    k, at = put_own(own, 0, CONTACT, rows, 0)
    for side in range(2):
        if contact[side]:
            stand[side], at = at, put(contact_task(d, side, gains), rows, at)
    k, momentum = put_own(own, k, MOMENTUM, rows, at)
    at = put(momentum_task(d, plan, mass, gains), rows, momentum)
    k, at = put_own(own, k, SWING, rows, at)
    for side in range(2):
        if swings[side]:
            t = target[side]
            of_side = SwingTarget(t[0], t[1], t[2], t[3], t[4], t[5])
            swing[side], at = at, put(swing_task(d, side, of_side, slopes[side], gains), rows, at)
    k, posture = put_own(own, k, POSTURE, rows, at)
    at = put(joint_task(d, arms[0], arms[1], gains), rows, posture)
    put_own(own, k, np.inf, rows, at)
    places = Places((stand[0], stand[1]), momentum, (swing[0], swing[1]), posture, nw)
    return rows, places
