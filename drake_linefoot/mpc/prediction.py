"""Where the robot will be when a plan that is being made begins to be used."""

from scipy.spatial.transform import Rotation

from drake_linefoot.centroidal import sample_plan
from drake_linefoot.mpc.models.model import CentroidalMeasurement
from drake_linefoot.signals import CentroidalPlan
from drake_linefoot.types import Array


def predict(
    measured: CentroidalMeasurement, w_WB: Array, plan: CentroidalPlan, now: float, then: float
) -> CentroidalMeasurement:
    """Return the state some milliseconds ahead, while a plan is carried out.

    CoM and angular momentum change as the plan changes them, (23) and (24); the torso goes on
    turning as it does.

    Args:
        measured: the state now.
        w_WB: angular velocity of the torso in W [rad/s], shape (3,).
        plan: that is carried out until `then`.
        now: [s].
        then: [s].

    Returns:
        The state at `then`.
    """
    dt = then - now
    before, after = sample_plan(plan, now), sample_plan(plan, then)
    return CentroidalMeasurement(
        r=measured.r + measured.v * dt + (after.r - before.r - before.v * dt),
        v=measured.v + (after.v - before.v),
        L=measured.L + (after.L - before.L),
        R_WB=Rotation.from_rotvec(dt * w_WB).as_matrix() @ measured.R_WB,
    )
