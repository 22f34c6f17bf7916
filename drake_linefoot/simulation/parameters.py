"""What a controller must survive: entries of a scenario, all off by default."""

from dataclasses import dataclass, field


@dataclass
class PushParameters:
    """A horizontal force on the torso for a while, of constant size. Units in brackets."""

    time: float = 0.0  # [s] when it begins
    duration: float = 0.1  # [s] a multiple of plant.time_step, so that the impulse is exact
    impulse: float = 0.0  # [N s] force times duration
    direction: float = 0.0  # [rad] from the torso's heading when it begins; pi/2 is to the left

    @property
    def force(self) -> float:
        """Size of the force [N]."""
        return self.impulse / self.duration


@dataclass
class GroundParameters:
    """Numbers of the scene that a scenario gives; none: those of the scene's file."""

    friction: float | None = None  # [-] of a foot on it
    point_contact_stiffness: float | None = None  # [N/m] of the ground alone
    hunt_crossley_dissipation: float | None = None  # [s/m]
    slope: float | None = None  # [rad] of the plane that begins at x = 0.5 m
    slope_heading: float | None = None  # [rad] direction of its steepest ascent, 0 is x
    step_height: float | None = None  # [m] largest difference of neighbouring random tiles
    tile: float | None = None  # [m] edge of the tiles
    ledge_height: float | None = None  # [m] of the ground beyond a step across the path
    ledge_at: float | None = None  # [m] where that begins in x


@dataclass
class SensorParameters:
    """White noise on what the controller measures: standard deviations. Units in brackets."""

    joint_position: float = 0.0  # [rad]
    joint_velocity: float = 0.0  # [rad/s]
    orientation: float = 0.0  # [rad] about each axis, of the torso
    gyro: float = 0.0  # [rad/s] angular velocity of the torso
    position: float = 0.0  # [m] of the torso
    velocity: float = 0.0  # [m/s] linear, of the torso
    encoder_resolution: float = 0.0  # [rad] joint angles come in steps of it; 0: continuous

    @property
    def are_perfect(self) -> bool:
        """Whether the controller gets the true state."""
        return not any(vars(self).values())


@dataclass
class ErrorParameters:
    """How the simulated robot differs from the model of its controller. Units in brackets."""

    torso_mass: float = 0.0  # [kg] added; the inertia grows with it
    leg_mass_scale: float = 1.0  # [-] of every body of both legs
    torso_com: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])  # [m] moved by, in B
    joint_damping: float = 0.0  # [N m s/rad] added to every joint
    joint_friction: float = 0.0  # [N m] Coulomb friction of every joint

    @property
    def changes_the_model(self) -> bool:
        """Whether masses, inertias or damping differ."""
        return self.leg_mass_scale != 1.0 or any(
            (self.torso_mass, *self.torso_com, self.joint_damping)
        )


@dataclass
class ActuatorParameters:
    """What motors make of the torque they are told. Units in brackets."""

    torque_speed: bool = False  # torque falls with speed, to none at the joint's velocity limit
    base_speed_share: float = 0.5  # [-] of that limit, up to which there is the full effort
    delay: float = 0.0  # [s] whole steps of the plant, at most 0.006
