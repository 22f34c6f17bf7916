"""Where the robot will be when a plan that is being made begins to be used."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from drake_linefoot.math.so3 import exp
from drake_linefoot.mpc.solve import CentroidalMeasurement
from drake_linefoot.robot.dynamics import GRAVITY
from drake_linefoot.signals import CentroidalPlan

Array = NDArray[np.float64]


def predict(
    measured: CentroidalMeasurement, w_WB: ArrayLike, plan: CentroidalPlan, now: float, then: float
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
    before, after = plan.sample(now, GRAVITY), plan.sample(then, GRAVITY)
    return CentroidalMeasurement(
        r=measured.r + measured.v * dt + (after.r - before.r - before.v * dt),
        v=measured.v + (after.v - before.v),
        L=measured.L + (after.L - before.L),
        R_WB=exp(dt * np.asarray(w_WB)) @ measured.R_WB,
    )
