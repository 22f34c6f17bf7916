"""The models "srbm" and "srbm_momentum": the robot as it is now, with joints that are locked.

A single rigid body turns as the torso does, whatever the legs do: "srbm" starts from the momentum
of the torso's rate, ``L = R I_B Omega``, as in the paper's reference [22]; "srbm_momentum" from
that of the whole robot.
"""

from dataclasses import replace

import numpy as np

from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.discretisation import times_vector
from drake_linefoot.mpc.models.model import CentroidalMeasurement, Model, measure_centroidal
from drake_linefoot.mpc.models.motion import LinePlan, Robot, middles, write_momentum
from drake_linefoot.robot.leg_inertia import whole_in_torso
from drake_linefoot.signals import RobotDynamics, open_dynamics, open_reference
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


def measure_torso(dynamics: RobotDynamics) -> CentroidalMeasurement:
    """Return the centroidal state with the momentum of a robot that turns as its torso does."""
    return replace(measure_centroidal(dynamics), L=dynamics.A[:3, :3] @ dynamics.v[:3])


SINGLE_BODY = Model("srbm", "single rigid body", locked_legs, measure=measure_torso)
SINGLE_BODY_MOMENTUM = Model("srbm_momentum", "single rigid body, whole momentum", locked_legs)
