"""Parameters of the whole-body controller."""

from dataclasses import dataclass


@dataclass
class WbcParameters:
    """Gains and weights. Units in brackets."""

    com_position_gain: float = 0.0  # [1/s^2] K_P,r of (52); the paper shows 0
    com_velocity_gain: float = 0.0  # [1/s] K_D,r of (52)
    angular_momentum_gain: float = 0.0  # [1/s] K_P,L of (53)
    swing_position_gain: float = 1600.0  # [1/s^2] position, pitch and yaw of the swing foot
    swing_velocity_gain: float = 80.0  # [1/s]
    stop_margin: float = 0.05  # [rad] a joint of the legs keeps off its stops
    stop_rate: float = 80.0  # [1/s] of the spring that it may not be faster than there
    arm_position_gain: float = 100.0  # [1/s^2]
    arm_velocity_gain: float = 20.0  # [1/s]
    contact_velocity_gain: float = 50.0  # [1/s] damps what a standing foot still moves, on an edge
    force_error_weight: float = 0.01  # [1/N^2] Q_1 of (49) on forces
    torque_error_weight: float = 0.1  # [1/(N m)^2] Q_1 of (49) on torques
    acceleration_error_weight: float = 10.0  # [s^4/m^2, s^4/rad^2] Q_2 of (49)
    friction: float = 0.6  # [-] in the contact cones
    solver: str = "osqp"  # Drake solver of the wrench program
    tolerance: float = 1e-8  # [-] of the scaled program
    max_iterations: int = 4000  # [-]
