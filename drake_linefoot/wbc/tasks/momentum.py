"""The robot follows the momentum of the plan."""

import numpy as np

from drake_linefoot.centroidal import PlanSample
from drake_linefoot.math.compiled import compiled
from drake_linefoot.signals import RobotDynamics
from drake_linefoot.wbc.tasks.task import Gains, TaskRows


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
