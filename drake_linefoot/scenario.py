"""The scenario: everything that makes a run what it is, read from one YAML file."""

from dataclasses import dataclass, field

from drake_linefoot.contact.parameters import EstimatorParameters
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.mpc.parameters import MpcParameters
from drake_linefoot.simulation.parameters import (
    ActuatorParameters,
    ErrorParameters,
    GroundParameters,
    PushParameters,
    SensorParameters,
)
from drake_linefoot.wbc.parameters import WbcParameters


@dataclass
class Segment:
    """A command that is held for a while."""

    name: str = "stand"  # shown in tables and metrics
    duration: float = 1.0  # [s]
    walk: bool = False  # false: stand on both feet
    velocity: list[float] = field(
        default_factory=lambda: [0.0, 0.0]
    )  # [m/s] forward, left, in the heading frame
    turn_rate: float = 0.0  # [rad/s] counter-clockwise positive


@dataclass
class Perturbation:
    """A random change of the initial state, uniform within these bounds."""

    joint_position: float = 0.0  # [rad]
    joint_velocity: float = 0.0  # [rad/s]
    base_velocity: float = 0.0  # [m/s] of the torso


@dataclass
class PlantParameters:
    """How the robot is simulated."""

    time_step: float = 0.001  # [s] also the period of estimator, gait and whole-body controller
    contact_approximation: str = "lagged"  # Drake's discrete contact approximation


@dataclass
class Scenario:
    """A run. Units in brackets."""

    name: str = "walk"
    robot: str = "mit_humanoid"  # a shipped model, or the path of a description
    scene: str = "flat_ground"  # a shipped scene, or the path of one
    ground: GroundParameters = field(default_factory=GroundParameters)  # instead of the scene's
    seed: int = 0  # [-] of everything random
    segments: list[Segment] = field(default_factory=lambda: [Segment()])
    perturbation: Perturbation = field(default_factory=Perturbation)
    pushes: list[PushParameters] = field(default_factory=list)
    error: ErrorParameters = field(default_factory=ErrorParameters)
    actuators: ActuatorParameters = field(default_factory=ActuatorParameters)
    sensors: SensorParameters = field(default_factory=SensorParameters)
    plant: PlantParameters = field(default_factory=PlantParameters)
    estimator: EstimatorParameters = field(default_factory=EstimatorParameters)
    gait: GaitParameters = field(default_factory=GaitParameters)
    mpc: MpcParameters = field(default_factory=MpcParameters)
    wbc: WbcParameters = field(default_factory=WbcParameters)

    @property
    def duration(self) -> float:
        """Length of all segments [s]."""
        return sum(segment.duration for segment in self.segments)
