"""A swinging foot follows its target."""

from drake_linefoot.axes import TORQUE_AXES, WRENCH
from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.rotation import axes_on_plane, cross, log
from drake_linefoot.signals import RobotDynamics, SwingTarget
from drake_linefoot.types import Array
from drake_linefoot.wbc.tasks.task import Gains, TaskRows


@compiled
def swing_task(
    d: RobotDynamics, side: int, target: SwingTarget, slope: Array, gains: Gains
) -> TaskRows:
    """Follow position and direction of the contact of a swinging foot; a sole is to lie flat.

    Args:
        d: present quantities.
        side: the foot.
        target: where it should be.
        slope: rise of the ground per metre along x and y of the world, shape (2,).
        gains: of the swing foot.

    Returns:
        As many rows as the wrench has numbers: position, the turn across a line, and of a sole
        the one about it.
    """
    kp, kd, R_WC = gains.swing_position, gains.swing_velocity, d.R_WC[side]
    if len(d.J[side]) == len(WRENCH):
        turn = log(axes_on_plane(target.d_W, slope) @ R_WC.T)
    else:
        turn = cross(R_WC[:, 0], target.d_W)  # from the line to its target
    a = target.a_WC + kd * (target.v_WC - d.v_WC[side]) + kp * (target.p_WC - d.p_WC[side])
    alpha = target.alpha_W + kd * (target.w_W - d.w_WF[side]) + kp * turn
    b = -d.Jdot_v[side]
    b[:3] += a
    in_C = alpha @ R_WC
    for i in range(3, len(b)):
        b[i] += in_C[TORQUE_AXES[i - 3]]
    return TaskRows(d.J[side], b)
