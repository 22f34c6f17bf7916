"""A swinging foot follows its target."""

from drake_linefoot.axes import TORQUE_AXES
from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.rotation import cross
from drake_linefoot.signals import RobotDynamics, SwingTarget
from drake_linefoot.wbc.tasks.task import Gains, TaskRows


@compiled
def swing_task(d: RobotDynamics, side: int, target: SwingTarget, gains: Gains) -> TaskRows:
    """Follow position and direction of the contact of a swinging foot.

    Args:
        d: present quantities.
        side: the foot.
        target: where it should be.
        gains: of the swing foot.

    Returns:
        As many rows as the wrench has numbers: position, and the turn across the line.
    """
    kp, kd, R_WC = gains.swing_position, gains.swing_velocity, d.R_WC[side]
    turn = cross(R_WC[:, 0], target.d_W)  # from the line to its target
    a = target.a_WC + kd * (target.v_WC - d.v_WC[side]) + kp * (target.p_WC - d.p_WC[side])
    alpha = target.alpha_W + kd * (target.w_W - d.w_WF[side]) + kp * turn
    b = -d.Jdot_v[side]
    b[:3] += a
    in_C = alpha @ R_WC
    for i in range(3, len(b)):
        b[i] += in_C[TORQUE_AXES[i - 3]]
    return TaskRows(d.J[side], b)
