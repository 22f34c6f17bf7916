"""Parameters of the whole-body controller."""

from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Le

from drake_linefoot.contact.solvers import MOST_ITERATIONS, SOLVERS
from drake_linefoot.fields import (
    Fixed,
    NotNegative,
    Positive,
    ScaledDefault,
    Share,
    Unit,
    Whole,
    one_of,
)
from drake_linefoot.parameters import Parameters

Stiffness = Annotated[NotNegative, Unit("1/s^2")]
Damping = Annotated[NotNegative, Unit("1/s")]


@dataclass
class WbcParameters(Parameters):
    """Gains and weights."""

    com_position_gain: Stiffness = ScaledDefault(0.0)
    """K_P,r of (52); the paper shows 0."""
    com_velocity_gain: Damping = ScaledDefault(0.0)
    """K_D,r of (52)."""
    angular_momentum_gain: Damping = ScaledDefault(0.0)
    """K_P,L of (53)."""
    swing_position_gain: Stiffness = ScaledDefault(1600.0)
    """Of position, pitch and yaw of the swing foot."""
    swing_velocity_gain: Damping = ScaledDefault(80.0)
    joint_limit_margin: Annotated[NotNegative, Unit("rad")] = 0.05
    """A joint of the legs keeps off its limits."""
    joint_limit_rate: Damping = ScaledDefault(80.0)
    """Of the spring that it may not be faster than there."""
    pitch_length: Annotated[Positive, Unit("m")] = ScaledDefault(0.05)
    """For which a radian of a foot is given up, when a joint is held off its limit."""
    arm_position_gain: Stiffness = ScaledDefault(100.0)
    arm_velocity_gain: Damping = ScaledDefault(20.0)
    contact_velocity_gain: Damping = ScaledDefault(50.0)
    """Damps what a standing foot still moves, on an edge."""
    force_error_weight: Annotated[Positive, Unit("1/N^2")] = ScaledDefault(0.01)
    """Q_1 of (49) on forces."""
    torque_error_weight: Annotated[Positive, Unit("1/(N m)^2")] = ScaledDefault(0.1)
    """Q_1 of (49) on torques."""
    acceleration_error_weight: Annotated[NotNegative, Unit("s^4/m^2")] = 10.0
    """Q_2 of (49) on the linear acceleration of the base."""
    angular_acceleration_error_weight: Annotated[NotNegative, Unit("s^4/rad^2")] = ScaledDefault(
        10.0
    )
    """Q_2 of (49) on its angular acceleration."""
    torque_limit_weight: Annotated[NotNegative, Unit("1/(N m)^2")] = ScaledDefault(10.0)
    """On what a torque exceeds its limit by; what is left of it is clipped."""
    friction: Share = 0.6
    """In the contact cones."""
    solver: Annotated[str, one_of(SOLVERS)] = "osqp"
    """Drake solver of the wrench program."""
    tolerance: Annotated[Share, Fixed()] = 1e-8
    """Of the scaled program."""
    max_iterations: Annotated[Whole, Ge(1), Le(MOST_ITERATIONS)] = 4000
