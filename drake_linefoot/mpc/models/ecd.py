"""The model "ecd", the paper's: inertia and momentum of legs that reach planned feet, (23)."""

from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.linear import copy
from drake_linefoot.mpc.models.model import Model
from drake_linefoot.mpc.models.motion import (
    LinePlan,
    Robot,
    arm_momentum,
    middles,
    relative_rates,
    write_momentum,
)
from drake_linefoot.mpc.models.reaching import reaching_legs
from drake_linefoot.robot.leg_inertia import momentum_of
from drake_linefoot.robot.leg_kinematics import rates
from drake_linefoot.signals import open_dynamics, open_reference
from drake_linefoot.types import Array


@compiled
def planned_legs(reference: Array, lines: LinePlan, dynamics: Array, robot: Robot) -> float:
    """Write a reference with legs that go where the feet are planned, (23).

    Args:
        reference: `Reference`, as it travels; behind `desired_motion` I_B, E and L are written,
            where there are any.
        lines: planned in the middles of the intervals.
        dynamics: `RobotDynamics` of the present state, as they travel.
        robot: what is to know of it.

    Returns:
        The largest residual of the inverse kinematics [m, rad].
    """
    ref = open_reference(reference, lines.p.shape[1])
    now = open_dynamics(dynamics, robot.nv, robot.nw)
    body = middles(ref)
    angles, maps, reach = reaching_legs(body, lines, now, robot)
    copy(maps.I_B, ref.I_B)
    v, w = relative_rates(body, lines)
    joint_rates = rates(robot.legs, angles, v, w)
    legs = momentum_of(maps.I_B, maps.angular, joint_rates, body.Omega)
    write_momentum(ref, legs + arm_momentum(ref, lines, now, robot))
    return reach


ECD = Model("ecd", "ECD", planned_legs)
