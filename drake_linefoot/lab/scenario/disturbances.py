"""What a controller must survive: entries of a scenario, all off by default."""

from dataclasses import dataclass, field
from typing import Annotated

from annotated_types import Ge, Le, Len, Lt
from pydantic import Strict

from drake_linefoot.fields import (
    Flag,
    NotNegative,
    Number,
    Positive,
    Share,
    TickOrMore,
    Triple,
    Unit,
)
from drake_linefoot.lab.scenario.courses import (
    LONGEST,
    BlocksParameters,
    GapsParameters,
    PatchParameters,
    SpiralParameters,
    StairsParameters,
    StonesParameters,
)
from drake_linefoot.parameters import Parameters

MOST_PATCHES = 2500  # of the ground

Stiffness = Annotated[Positive, Unit("N/m")]
Dissipation = Annotated[NotNegative, Unit("s/m")]
Slope = Annotated[Number, Ge(0), Le(0.8), Unit("rad")]
Angle = Annotated[Number, Unit("rad")]
Height = Annotated[NotNegative, Unit("m")]
Edge = Annotated[Number, Ge(0.01), Unit("m")]
Place = Annotated[Positive, Unit("m", 1e3)]
Metres = Annotated[Number, Unit("m")]


@dataclass
class PushParameters(Parameters):
    """A horizontal force on the torso for a while, of constant size."""

    time: Annotated[NotNegative, Unit("s", LONGEST)] = 0.0
    """When it begins."""
    duration: TickOrMore = 0.1
    """A multiple of plant.time_step, so that the impulse is exact."""
    impulse: Annotated[NotNegative, Unit("N s")] = 0.0
    """Force times duration."""
    direction: Annotated[Number, Unit("rad")] = 0.0
    """From the torso's heading when it begins; pi/2 is to the left."""

    @property
    def force(self) -> float:
        """Size of the force [N]."""
        return self.impulse / self.duration


@dataclass
class GroundParameters(Parameters):
    """Numbers of the scene that a scenario gives; none: those of the scene's file."""

    friction: Share | None = None
    """Of a foot on it."""
    point_contact_stiffness: Stiffness | None = None
    """Of the ground alone."""
    hunt_crossley_dissipation: Dissipation | None = None
    slope: Slope | None = None
    """Of the plane that begins at x = 0.5 m."""
    slope_heading: Angle | None = None
    """Direction of its steepest ascent, 0 is x."""
    step_height: Height | None = None
    """Largest difference of neighbouring tiles, random."""
    tile: Edge | None = None
    """Edge of the tiles."""
    ledge_height: Metres | None = None
    """Of the ground beyond a step across the path."""
    ledge_at: Place | None = None
    """Where that begins in x."""
    stairs: StairsParameters | None = None
    """Instead of all above, but friction and stiffness; so are the five that follow."""
    gaps: GapsParameters | None = None
    stones: StonesParameters | None = None
    blocks: BlocksParameters | None = None
    spiral: SpiralParameters | None = None
    patches: Annotated[list[PatchParameters], Strict(), Len(1, MOST_PATCHES)] | None = None
    """What they do not cover is no ground."""


@dataclass
class SensorParameters(Parameters):
    """White noise on what the controller measures: standard deviations."""

    joint_position: Annotated[NotNegative, Unit("rad")] = 0.0
    joint_velocity: Annotated[NotNegative, Unit("rad/s")] = 0.0
    orientation: Annotated[NotNegative, Unit("rad")] = 0.0
    """About each axis, of the torso."""
    gyro: Annotated[NotNegative, Unit("rad/s")] = 0.0
    """Angular velocity of the torso."""
    position: Annotated[NotNegative, Unit("m")] = 0.0
    """Of the torso."""
    velocity: Annotated[NotNegative, Unit("m/s")] = 0.0
    """Linear, of the torso."""
    encoder_resolution: Annotated[NotNegative, Unit("rad")] = 0.0
    """Joint angles come in steps of it; 0: continuous."""

    @property
    def are_perfect(self) -> bool:
        """Whether the controller gets the true state."""
        return not any(vars(self).values())


@dataclass
class ErrorParameters(Parameters):
    """How the simulated robot differs from the model of its controller."""

    torso_mass: Annotated[Number, Unit("kg")] = 0.0
    """Added; the inertia grows with it."""
    leg_mass_scale: Share = 1.0
    """Of every body of both legs."""
    torso_com: Annotated[Triple, Unit("m")] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    """Moved by, in B."""
    joint_damping: Annotated[NotNegative, Unit("N m s/rad")] = 0.0
    """Added to every joint."""
    joint_friction: Annotated[NotNegative, Unit("N m")] = 0.0
    """Coulomb friction of every joint."""

    @property
    def changes_the_model(self) -> bool:
        """Whether masses, inertias or damping differ."""
        return self.leg_mass_scale != 1.0 or any(
            (self.torso_mass, *self.torso_com, self.joint_damping)
        )


@dataclass
class ActuatorParameters(Parameters):
    """What motors make of the torque that is commanded."""

    torque_speed: Flag = False
    """Torque falls with speed, to none at the joint's velocity limit."""
    base_speed_share: Annotated[Number, Ge(0), Lt(1)] = 0.5
    """Of that limit, up to which there is the full effort."""
    delay: Annotated[Number, Ge(0), Le(0.006), Unit("s")] = 0.0
    """Whole steps of the plant."""
