"""Parameters of the gait."""

from dataclasses import dataclass, field


@dataclass
class GaitParameters:
    """How the robot steps. Units in brackets; defaults walk the MIT Humanoid."""

    single_support: float = 0.20  # [s]
    double_support: float = 0.03  # [s]
    step_length: float = 0.28  # [m] forward; a walk whose steps would be longer steps faster
    single_support_min: float = 0.14  # [s] but not faster than this
    shift_duration: float = 0.40  # [s] weight shift before the first step
    step_width: float = 0.16  # [m] between the feet
    swing_height: float = 0.06  # [m] apex of the swing foot
    com_height: float = 0.642  # [m] above the stance foot
    linear_acceleration: float = 1.0  # [m/s^2] rate limit of the commanded velocity
    angular_acceleration: float = 1.5  # [rad/s^2] rate limit of the commanded turn rate
    forward_max: float = 1.5  # [m/s] commands are clipped here, forward and backward
    lateral_max: float = 0.5  # [m/s]
    turn_max: float = 2.0  # [rad/s]
    capture_rate: float = 3.0  # [1/s] how fast a standing robot brings its DCM to the middle
    speed_scale: list[float] = field(default_factory=lambda: [1.08, 1.2])  # [-] of the commanded
    # velocity, forward and left, that footholds are made for; where learning starts
    speed_learning: float = 0.15  # [-] share of the relative speed error learned each step
    speed_scale_max: float = 1.5  # [-] bound of the learned scale; 1 / it is the other bound
    speed_offset_max: float = 0.2  # [m/s] bound of the learned offset
    contact_feedback: bool = True  # a swing ends when the estimator says so; else when planned
    early_contact_phase: float = 0.6  # [-] of the swing; contact before it is not believed
    contact_speed: float = 0.1  # [m/s] a foot that goes down faster has found no ground yet
    late_contact_max: float = 0.03  # [s] a foot that finds no ground reaches down for so long
    late_contact_wait: float = 0.01  # [s] after which one that does not follow has found it
    reach_speed: float = 0.2  # [m/s] at which it does
    slope_learning: float = 1.0  # [-] weight of what two feet say of the slope against the belief
    slope_max: float = 0.3  # [-] bound of the slope, in x and in y
    reach_forward: float = 0.22  # [m] of a landing foot from the CoM, ahead or behind
    reach_outward: float = 0.28  # [m] of a landing foot from the CoM, to its own side
    step_time_decrement: float = 0.01  # [s] by which a step is shortened while out of reach
    remaining_time_min: float = 0.08  # [s] but not so that less is left of the swing
    swing_time_min: float = 0.10  # [s] nor the whole swing takes less
    swing_acceleration_max: float = 200.0  # [m/s^2] along the ground, in a shortened step
    settle_time: float = 0.03  # [s] before touchdown the foot is above its foothold
    freeze_time: float = 0.02  # [s] before that the foothold moves no more
    closing_tolerance: float = 0.04  # [m] of the foothold, to end a walk beside the stance foot
    first_swing: str = "right"  # foot that makes the first step, "left" or "right"
