"""What the gait measures of the robot."""

from __future__ import annotations

import numpy as np

from drake_linefoot.gait.planner import GaitMeasurement
from drake_linefoot.gait.swing_kernels import contact_lines
from drake_linefoot.robot.dynamics import RobotDynamics


def measure_gait(dynamics: RobotDynamics, contact: tuple[bool, bool]) -> GaitMeasurement:
    """Return CoM and contact lines of a state.

    Args:
        dynamics: quantities of the state.
        contact: flags of the contact estimator.
    """
    left, right = dynamics.feet
    feet, rise = contact_lines(left.p_WC, left.R_WC, right.p_WC, right.R_WC)
    return GaitMeasurement(
        com=dynamics.p_WG,
        com_velocity=dynamics.v_WG,
        feet=feet,
        contact=contact,
        rise=rise,
        climb=np.array([left.v_WC[2], right.v_WC[2]]),
    )
