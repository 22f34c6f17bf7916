"""The tasks of the whole-body controller, in the order of their priority."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.math.so3 import cross
from drake_linefoot.robot.dynamics import RobotDynamics
from drake_linefoot.signals import PlanSample, SwingTarget
from drake_linefoot.wbc.parameters import WbcParameters
from drake_linefoot.wbc.priorities import TaskRows

Array = NDArray[np.float64]


def contact_task(dynamics: RobotDynamics, sides: Sequence[int], damping: float) -> TaskRows:
    """Keep the lines of standing feet where they are: ``J_c vdot = -Jdot_c v - k J_c v``.

    Args:
        dynamics: present quantities.
        sides: standing feet.
        damping: k [1/s].

    Returns:
        Five rows for each standing foot.
    """
    nv = len(dynamics.v)
    if not sides:
        return TaskRows(np.zeros((0, nv)), np.zeros(0))
    J = np.vstack([dynamics.feet[i].J for i in sides])
    bias = np.concatenate([dynamics.feet[i].Jdot_v for i in sides])
    return TaskRows(J, -bias - damping * (J @ dynamics.v))


def momentum_task(
    dynamics: RobotDynamics, plan: PlanSample, mass: float, parameters: WbcParameters
) -> TaskRows:
    """Follow the plan's angular and linear momentum, (52), (53).

    Args:
        dynamics: present quantities.
        plan: the centroidal plan now.
        mass: [kg].
        parameters: gains.

    Returns:
        Six rows, angular over linear.
    """
    p = parameters
    a = (
        plan.a
        - p.com_velocity_gain * (dynamics.v_WG - plan.v)
        - p.com_position_gain * (dynamics.p_WG - plan.r)
    )
    L_dot = plan.L_dot - p.angular_momentum_gain * (dynamics.L_G - plan.L)
    return TaskRows(dynamics.A, np.concatenate([L_dot, mass * a]) - dynamics.Adot_v)


def swing_task(
    dynamics: RobotDynamics, side: int, target: SwingTarget, parameters: WbcParameters
) -> TaskRows:
    """Follow position and direction of the swing foot's contact line.

    Args:
        dynamics: present quantities.
        side: the swing foot.
        target: where it should be.
        parameters: gains.

    Returns:
        Five rows: position, and the turn across the line.
    """
    foot = dynamics.feet[side]
    kp, kd = parameters.swing_position_gain, parameters.swing_velocity_gain
    linear = target.a_WC + kd * (target.v_WC - foot.v_WC) + kp * (target.p_WC - foot.p_WC)
    turn = cross(foot.R_WC[:, 0], target.d_W)
    angular = target.alpha_W + kd * (target.w_W - foot.w_WF) + kp * turn
    wanted = np.concatenate([linear, foot.R_WC[:, 1:].T @ angular])
    return TaskRows(foot.J, wanted - foot.Jdot_v)


def joint_task(
    dynamics: RobotDynamics, index_v: Array, index_q: Array, q_d: Array, kp: float, kd: float
) -> TaskRows:
    """Hold joints at given angles.

    Args:
        dynamics: present quantities.
        index_v: where the joints stand in v, shape (m,).
        index_q: where they stand in q, shape (m,).
        q_d: desired angles [rad], shape (m,).
        kp: [1/s^2].
        kd: [1/s].

    Returns:
        One row for each joint.
    """
    J = np.zeros((len(index_v), len(dynamics.v)))
    J[np.arange(len(index_v)), index_v] = 1.0
    return TaskRows(J, kp * (q_d - dynamics.q[index_q]) - kd * dynamics.v[index_v])
