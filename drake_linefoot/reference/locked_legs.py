"""The reference of the single rigid body: the robot as it is now, with joints that are locked."""

import numpy as np

from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.discretisation import times_vector
from drake_linefoot.reference.motion import LinePlan, Robot, middles, write_momentum
from drake_linefoot.robot.leg_inertia import whole_in_torso
from drake_linefoot.signals import open_dynamics, open_reference
from drake_linefoot.types import Array


@compiled
def locked_legs(reference: Array, lines: LinePlan, dynamics: Array, robot: Robot) -> float:
    """Write a reference with the present inertia; otherwise as `planned_legs`.

    Returns:
        0: no leg has to reach anything.
    """
    ref = open_reference(reference, lines.p.shape[1])
    now, body = open_dynamics(dynamics, robot.nv, robot.nw), middles(ref)
    _, inertia = whole_in_torso(now.q, now.p_WG, now.R_WB, now.A)
    L_B = np.empty(body.Omega.shape)
    for k in range(len(L_B)):
        for i in range(3):
            for j in range(3):
                ref.I_B[k, i, j] = inertia[i, j]
        times_vector(inertia, body.Omega[k], L_B[k])
    write_momentum(ref, L_B)
    return 0.0
