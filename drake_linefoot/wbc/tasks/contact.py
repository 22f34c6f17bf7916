"""Standing feet stay where they are."""

from drake_linefoot.math.compiled import compiled
from drake_linefoot.signals import RobotDynamics
from drake_linefoot.wbc.tasks.task import Gains, TaskRows


@compiled
def contact_task(d: RobotDynamics, side: int, gains: Gains) -> TaskRows:
    """Keep the contact of a standing foot where it is: ``J_c vdot = -Jdot_c v - k J_c v``.

    Args:
        d: present quantities.
        side: the standing foot.
        gains: k is `contact_velocity`.

    Returns:
        As many rows as the wrench has numbers.
    """
    J = d.J[side]
    return TaskRows(J, -d.Jdot_v[side] - gains.contact_velocity * (J @ d.v))
