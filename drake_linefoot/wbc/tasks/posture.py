"""Joints that nothing else decides are held at given angles, or swing with the feet."""

from typing import NamedTuple

import numpy as np

from drake_linefoot.math.compiled import compiled
from drake_linefoot.signals import RobotDynamics
from drake_linefoot.types import Array, Indices
from drake_linefoot.wbc.tasks.task import Gains, TaskRows


class Joints(NamedTuple):
    """Joints that are held at an angle.

    Attributes:
        index_q: places in q, shape (m,).
        index_v: places in v, shape (m,).
        q_d: desired angles [rad], shape (m,).
        turns: which way each turns with `GaitTargets.arms`, 1, -1 or 0, shape (m,).
    """

    index_q: Indices
    index_v: Indices
    q_d: Array
    turns: Array


@compiled
def joint_task(d: RobotDynamics, joints: Joints, arms: Array, gains: Gains) -> TaskRows:
    """Hold joints at given angles, or swing them; one row for each.

    Args:
        d: present quantities.
        joints: which, and where.
        arms: `GaitTargets.arms`, shape (3,).
        gains: of the joints.
    """
    J, b = np.zeros((len(joints.q_d), len(d.v))), np.empty(len(joints.q_d))
    for i in range(len(b)):
        q, v = d.q[joints.index_q[i]], d.v[joints.index_v[i]]
        angle, rate, acceleration = joints.turns[i] * arms
        J[i, joints.index_v[i]] = 1.0
        b[i] = acceleration + gains.joint_velocity * (rate - v)
        b[i] += gains.joint_position * (joints.q_d[i] + angle - q)
    return TaskRows(J, b)
