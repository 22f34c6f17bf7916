"""The reference of the model "ecd": inertia and momentum of legs that reach planned feet."""

from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.linear import copy
from drake_linefoot.reference.motion import (
    LinePlan,
    Robot,
    joints,
    joints_of_legs,
    middles,
    relative_rates,
    write_momentum,
)
from drake_linefoot.robot.leg_inertia import (
    momentum_maps,
    momentum_of,
    weigh_torso,
    whole_in_torso,
)
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
    legs, K = robot.legs, lines.p.shape[1]
    ref, now = open_reference(reference, K), open_dynamics(dynamics, robot.nv)
    body = middles(ref)
    com, inertia = whole_in_torso(now.q, now.p_WG, now.R_WB, now.A)
    angles_now = joints_of_legs(now.q, robot.leg_q)
    weigh_torso(legs, robot.masses, angles_now, com, inertia)
    angles, reach = joints(legs, body, lines, com, angles_now)
    maps = momentum_maps(legs, robot.masses, angles)
    copy(maps.I_B, ref.I_B)
    v, w = relative_rates(body, lines)
    write_momentum(ref, momentum_of(maps.I_B, maps.angular, rates(legs, angles, v, w), body.Omega))
    return reach
