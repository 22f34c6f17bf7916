"""Parameters of the model-predictive controller."""

from dataclasses import dataclass, field
from typing import Annotated

from annotated_types import Ge, Le, Len
from pydantic import Strict

from drake_linefoot.contact.solvers import MOST_ITERATIONS, SOLVERS
from drake_linefoot.fields import (
    Fixed,
    Flag,
    NotNegative,
    Positive,
    ScaledDefault,
    Share,
    Size,
    TickOrMore,
    Unit,
    Whole,
    is_multiple,
    misfit,
    one_of,
    together,
)
from drake_linefoot.mpc.models.registry import MODELS
from drake_linefoot.parameters import Parameters

LONGEST_HORIZON = 10.0  # [s]
ACTIVE_SET = "active_set"  # solves the program exactly by guessing which rows are active
MPC_SOLVERS = (*SOLVERS, ACTIVE_SET)

Weights = Annotated[list[NotNegative], Strict(), Len(3, 3)]


def _of_robot(*weights: float) -> list[float]:
    return [ScaledDefault(weight) for weight in weights]


@dataclass
class MpcWeights(Parameters):
    """Diagonals of L and K in (40); the cost is a weighted squared norm per unit of state."""

    position: Annotated[Weights, Unit("1/m^2")] = field(
        default_factory=lambda: _of_robot(0.0, 0.0, 2000.0)
    )
    velocity: Annotated[Weights, Unit("s^2/m^2")] = field(
        default_factory=lambda: _of_robot(10.0, 10.0, 10.0)
    )
    angular_momentum: Annotated[Weights, Unit("1/(kg m^2/s)^2")] = field(
        default_factory=lambda: _of_robot(0.1, 0.1, 0.1)
    )
    orientation: Annotated[Weights, Unit("1/rad^2"), Size("torso_inertia")] = field(
        default_factory=lambda: _of_robot(300.0, 300.0, 300.0)
    )
    force: Annotated[Positive, Unit("1/N^2")] = ScaledDefault(1e-5)
    torque: Annotated[Positive, Unit("1/(N m)^2")] = ScaledDefault(1e-4)
    centre_of_pressure: Annotated[NotNegative, Unit("1/N^2")] = ScaledDefault(5e-6)
    """On tau_y / X and tau_x / Y of a sole, a normal force at its edge; 0 lets it be anywhere."""


@dataclass
class MpcParameters(Parameters):
    """Horizon, weights and solver."""

    model: Annotated[str, one_of(MODELS)] = "contact_consistent"
    """"contact_consistent": the torso turns over its feet and no joint is locked; "ecd": the
    paper's; "srbm": the single rigid body with frozen inertia, from the torso's rate;
    "srbm_momentum": the same from the whole body's momentum; or one that `register` made known."""
    knots: Annotated[Whole, Ge(1), Le(200)] = 14
    """Intervals of the horizon."""
    knot_step: Annotated[TickOrMore, Fixed()] = ScaledDefault(0.04)
    """Longest interval."""
    period: Annotated[TickOrMore, Fixed()] = 0.02
    """Between two updates."""
    run_period: Annotated[TickOrMore, Fixed()] = 0.01
    """Likewise in a run, where `period` is a multiple of it and plans are not used late."""
    late: Flag = False
    """Each plan is used one period later, as if computing it took that long."""
    process: Flag = False
    """It is computed in a process of its own; with that each plan is used one period later."""
    friction: Share = 0.6
    """In the contact cones; below the ground's."""
    weights: MpcWeights = field(default_factory=MpcWeights)
    solver: Annotated[str, one_of(MPC_SOLVERS)] = "osqp"
    """Drake's "osqp" or "clarabel"; or "active_set", OSQP where it fails."""
    tolerance: Annotated[Share, Fixed()] = 1e-6
    """Of the scaled program; leaves a tenth of a newton."""
    max_iterations: Annotated[Whole, Ge(1), Le(MOST_ITERATIONS)] = 10000

    @together
    def _looks_ahead_a_few_steps(self) -> None:
        if self.knots * self.knot_step > LONGEST_HORIZON:
            allowed = f"must give a horizon of at most {LONGEST_HORIZON:g} s"
            raise misfit("knot_step", self.knot_step, allowed)

    @property
    def shortest_period(self) -> float:
        """Between two updates in a run [s]."""
        often = self.period >= self.run_period and is_multiple(self.period, self.run_period)
        return self.run_period if often and not self.lead else self.period

    @property
    def lead(self) -> float:
        """From the state a plan is made of to when it begins to be used [s]."""
        return self.period if self.late or self.process else 0.0

    @property
    def horizon(self) -> float:
        """What has to be known ahead of the present state [s]."""
        return self.lead + self.knots * self.knot_step
