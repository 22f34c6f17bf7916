"""What the gait measures of the robot."""

from __future__ import annotations

from drake_linefoot.gait.planner import GaitMeasurement
from drake_linefoot.gait.swing_kernels import climb_of_lines, contact_lines
from drake_linefoot.robot.dynamics import RobotDynamics


def measure_gait(
    dynamics: RobotDynamics, contact: tuple[bool, bool], half_length: float
) -> GaitMeasurement:
    """Return CoM and contact lines of a state.

    Args:
        dynamics: quantities of the state.
        contact: flags of the contact estimator.
        half_length: X [m].
    """
    feet, rise = contact_lines(dynamics.lines, dynamics.R_WC)
    climb = climb_of_lines(dynamics.lines, dynamics.R_WC, half_length)
    return GaitMeasurement(dynamics.p_WG, dynamics.v_WG, feet, contact, rise, climb)
