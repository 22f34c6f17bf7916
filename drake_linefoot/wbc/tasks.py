"""The tasks of the whole-body controller, ``J vdot = b``, in the order of their priority."""

from typing import NamedTuple

import numpy as np

from drake_linefoot.centroidal import PlanSample
from drake_linefoot.math.compiled import compiled, inlined
from drake_linefoot.math.rotation import cross
from drake_linefoot.signals import RobotDynamics, SwingTarget
from drake_linefoot.types import Array, Indices


class TaskRows(NamedTuple):
    """A task ``J vdot = b``.

    Attributes:
        J: Jacobian, shape (m, nv).
        b: desired acceleration minus the bias Jdot v, shape (m,).
    """

    J: Array
    b: Array


class Gains(NamedTuple):
    """Gains of the tasks, see `WbcParameters`.

    Attributes:
        com_position: K_P,r of (52) [1/s^2].
        com_velocity: K_D,r of (52) [1/s].
        angular_momentum: K_P,L of (53) [1/s].
        swing_position: of the swing foot [1/s^2].
        swing_velocity: of the swing foot [1/s].
        joint_position: of the arms [1/s^2].
        joint_velocity: of the arms [1/s].
        contact_velocity: damping of standing feet [1/s].
    """

    com_position: float
    com_velocity: float
    angular_momentum: float
    swing_position: float
    swing_velocity: float
    joint_position: float
    joint_velocity: float
    contact_velocity: float


class Joints(NamedTuple):
    """Joints that are held at an angle.

    Attributes:
        index_q: places in q, shape (m,).
        index_v: places in v, shape (m,).
        q_d: desired angles [rad], shape (m,).
    """

    index_q: Indices
    index_v: Indices
    q_d: Array


@compiled
def contact_task(d: RobotDynamics, side: int, gains: Gains) -> TaskRows:
    """Keep the line of a standing foot where it is: ``J_c vdot = -Jdot_c v - k J_c v``.

    Args:
        d: present quantities.
        side: the standing foot.
        gains: k is `contact_velocity`.

    Returns:
        Five rows.
    """
    J = d.J[side]
    return TaskRows(J, -d.Jdot_v[side] - gains.contact_velocity * (J @ d.v))


@compiled
def momentum_task(d: RobotDynamics, plan: PlanSample, mass: float, gains: Gains) -> TaskRows:
    """Follow the plan's angular and linear momentum, (52), (53).

    Args:
        d: present quantities.
        plan: the centroidal plan now.
        mass: [kg].
        gains: of CoM and angular momentum.

    Returns:
        Six rows, angular over linear.
    """
    L_G = d.A[:3] @ d.v
    r_error, v_error = d.p_WG - plan.r, d.v_WG - plan.v
    rate = np.empty(6)
    rate[:3] = plan.L_dot - gains.angular_momentum * (L_G - plan.L)
    rate[3:] = mass * (plan.a - gains.com_velocity * v_error - gains.com_position * r_error)
    return TaskRows(d.A, rate - d.Adot_v)


@compiled
def swing_task(d: RobotDynamics, side: int, target: SwingTarget, gains: Gains) -> TaskRows:
    """Follow position and direction of the swing foot's contact line.

    Args:
        d: present quantities.
        side: the swing foot.
        target: where it should be.
        gains: of the swing foot.

    Returns:
        Five rows: position, and the turn across the line.
    """
    kp, kd, R_WC = gains.swing_position, gains.swing_velocity, d.R_WC[side]
    turn = cross(R_WC[:, 0], target.d_W)  # from the line to its target
    a = target.a_WC + kd * (target.v_WC - d.v_WC[side]) + kp * (target.p_WC - d.p_WC[side])
    alpha = target.alpha_W + kd * (target.w_W - d.w_WF[side]) + kp * turn
    b = -d.Jdot_v[side]
    b[:3] += a
    b[3:] += (alpha @ R_WC)[1:]
    return TaskRows(d.J[side], b)


@compiled
def joint_task(d: RobotDynamics, joints: Joints, gains: Gains) -> TaskRows:
    """Hold joints at given angles; one row for each.

    Args:
        d: present quantities.
        joints: which, and where.
        gains: of the joints.
    """
    J, b = np.zeros((len(joints.q_d), len(d.v))), np.empty(len(joints.q_d))
    for i in range(len(b)):
        q, v = d.q[joints.index_q[i]], d.v[joints.index_v[i]]
        J[i, joints.index_v[i]] = 1.0
        b[i] = gains.joint_position * (joints.q_d[i] - q) - gains.joint_velocity * v
    return TaskRows(J, b)


@compiled
def put(task: TaskRows, rows: TaskRows) -> TaskRows:
    """Write a task into the first of some rows; return those that are left, as views."""
    n = len(task.b)
    rows.J[:n], rows.b[:n] = task.J, task.b
    return TaskRows(rows.J[n:], rows.b[n:])


@inlined
def stacked_tasks(
    d: RobotDynamics,
    contact: tuple[bool, bool],
    plan: PlanSample,
    swings: bool,
    swing: SwingTarget,
    mass: float,
    gains: Gains,
    arms: Joints,
) -> TaskRows:
    """Return all tasks of a tick, one below the other in the order of priority.

    Standing feet, left before right; momentum; the swing foot, if there is one; the arms.

    Args:
        d: present quantities.
        contact: whether the left and the right foot stand.
        plan: the centroidal plan now.
        swings: whether the foot that does not stand has a target.
        swing: that target.
        mass: [kg].
        gains: of all tasks.
        arms: the joints that the legs do not use.
    """
    size = 5 * (int(contact[0]) + int(contact[1]) + int(swings)) + 6 + len(arms.q_d)
    rows = left = TaskRows(np.empty((size, len(d.v))), np.empty(size))
    for side in range(2):
        if contact[side]:
            left = put(contact_task(d, side, gains), left)
    left = put(momentum_task(d, plan, mass, gains), left)
    if swings:
        left = put(swing_task(d, swing_side(contact), swing, gains), left)
    put(joint_task(d, arms, gains), left)
    return rows


@inlined
def swing_side(contact: tuple[bool, bool]) -> int:
    """Return the foot that swings when one does, 0 left, 1 right."""
    return 1 if contact[0] else 0
