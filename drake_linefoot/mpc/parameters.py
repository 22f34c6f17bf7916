"""Parameters of the model-predictive controller."""

from dataclasses import dataclass, field

ECD = "ecd"
SINGLE_BODY = "srbm"
MODELS = (ECD, SINGLE_BODY)

ACTIVE_SET = "active_set"  # solves the program exactly by guessing which rows are active


@dataclass
class MpcWeights:
    """Diagonals of L and K in (40); the cost is a weighted squared norm per unit of state."""

    position: list[float] = field(default_factory=lambda: [0.0, 0.0, 2000.0])  # [1/m^2]
    velocity: list[float] = field(default_factory=lambda: [10.0, 10.0, 10.0])  # [s^2/m^2]
    angular_momentum: list[float] = field(
        default_factory=lambda: [0.1, 0.1, 0.1]
    )  # [1/(kg m^2/s)^2]
    orientation: list[float] = field(default_factory=lambda: [300.0, 300.0, 300.0])  # [1/rad^2]
    force: float = 1e-5  # [1/N^2]
    torque: float = 1e-4  # [1/(N m)^2]


@dataclass
class MpcParameters:
    """Horizon, weights and solver. Units in brackets."""

    model: str = ECD  # "ecd", or "srbm": the single rigid body with frozen inertia
    knots: int = 14  # [-] intervals of the horizon
    knot_step: float = 0.04  # [s] longest interval
    period: float = 0.02  # [s] between two updates
    late: bool = False  # each plan is used one period later, as if computing it took that long
    friction: float = 0.6  # [-] in the contact cones; below the ground's
    weights: MpcWeights = field(default_factory=MpcWeights)
    solver: str = "osqp"  # Drake's "osqp" or "clarabel"; or "active_set", OSQP where it fails
    tolerance: float = 1e-6  # [-] of the scaled program; leaves a tenth of a newton
    max_iterations: int = 10000  # [-]

    @property
    def lead(self) -> float:
        """From the state a plan is made of to when it begins to be used [s]."""
        return self.period if self.late else 0.0

    @property
    def horizon(self) -> float:
        """What has to be known ahead of the present state [s]."""
        return self.lead + self.knots * self.knot_step
