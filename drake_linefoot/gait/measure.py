"""What the gait measures of the robot."""

from __future__ import annotations

import math

import numpy as np

from drake_linefoot.gait.planner import GaitMeasurement
from drake_linefoot.robot.dynamics import RobotDynamics


def measure_gait(dynamics: RobotDynamics, contact: tuple[bool, bool]) -> GaitMeasurement:
    """Return CoM and contact lines of a state.

    Args:
        dynamics: quantities of the state.
        contact: flags of the contact estimator.
    """
    feet = np.empty((2, 4))
    for side, foot in enumerate(dynamics.feet):
        feet[side, :3] = foot.p_WC
        feet[side, 3] = math.atan2(foot.R_WC[1, 0], foot.R_WC[0, 0])
    return GaitMeasurement(
        com=dynamics.p_WG, com_velocity=dynamics.v_WG, feet=feet, contact=contact
    )
