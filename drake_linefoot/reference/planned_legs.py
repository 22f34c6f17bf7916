"""The reference of the model "ecd": inertia and momentum of legs that reach planned feet."""

from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.linear import copy
from drake_linefoot.reference.motion import (
    LinePlan,
    Opened,
    Present,
    Robot,
    joints,
    joints_of_legs,
    middles,
    relative_rates,
    write_momentum,
)
from drake_linefoot.robot.leg_inertia import (
    Masses,
    momentum_maps,
    momentum_of,
    weigh_torso,
    whole_in_torso,
)
from drake_linefoot.robot.leg_kinematics import rates
from drake_linefoot.robot.legs import Legs
from drake_linefoot.signals import Reference


@compiled
def planned_legs(reference: Opened, lines: Opened, present: Opened, robot: Opened) -> float:
    """Write a reference with legs that go where the feet are planned, (23).

    Args:
        reference: `Reference` as a plain tuple, which Numba takes over faster; behind
            `desired_motion` I_B, E and L are written, where there are any.
        lines: `LinePlan`, likewise, as are the others.
        present: `Present`.
        robot: `Robot`.

    Returns:
        The largest residual of the inverse kinematics [m, rad].
    """
    now, own = Present(*present), Robot(*robot)
    legs, masses = Legs(*own.legs), Masses(*own.masses)
    ref, plan = Reference(*reference), LinePlan(*lines)
    body = middles(ref)
    com, inertia = whole_in_torso(now.q, now.p_WG, now.R_WB, now.A)
    angles_now = joints_of_legs(now.q, own.leg_q)
    weigh_torso(legs, masses, angles_now, com, inertia)
    angles, reach = joints(legs, body, plan, com, angles_now)
    maps = momentum_maps(legs, masses, angles)
    copy(maps.I_B, ref.I_B)
    v, w = relative_rates(body, plan)
    write_momentum(ref, momentum_of(maps.I_B, maps.angular, rates(legs, angles, v, w), body.Omega))
    return reach
