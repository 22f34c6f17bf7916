"""Parameters of the contact estimator."""

from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Lt

from drake_linefoot.fields import (
    NotNegative,
    Number,
    Positive,
    ScaledDefault,
    Share,
    Unit,
    misfit,
    one_of,
    together,
)
from drake_linefoot.parameters import Parameters

PSEUDOINVERSE = "pseudoinverse"
CONSTRAINED = "constrained"
METHODS = (PSEUDOINVERSE, CONSTRAINED)


@dataclass
class EstimatorParameters(Parameters):
    """How contacts are estimated."""

    filter_constant: Annotated[Number, Ge(0), Lt(1)] = 0.8
    """gamma of (21), per tick; 0 is unfiltered."""
    rate_bandwidth: Annotated[Positive, Unit("rad/s")] | None = None
    """Of the filter that has made the joint rates, as in `StateEstimatorParameters`; null: they
    are not late, and on an estimate of the state, as late as that makes them."""
    method: Annotated[str, one_of(METHODS)] = PSEUDOINVERSE
    """"pseudoinverse", or "constrained": the program (22)."""
    touch_force: Annotated[Positive, Unit("N")] = ScaledDefault(30.0)
    """Normal force above which a foot counts as standing."""
    release_force: Annotated[NotNegative, Unit("N")] = ScaledDefault(12.0)
    """Normal force below which it counts as in the air."""
    friction: Share = 0.8
    """In the cone of the constrained form."""
    external_time: Annotated[NotNegative, Unit("s")] = ScaledDefault(0.3)
    """In which the force is known that acts on the robot and is not of the ground; 0: never."""
    external_rate: Annotated[Positive, Unit("N/s")] = ScaledDefault(40.0)
    """So fast it is learned at most: little of a push, which ends before one can lean into it."""
    external_max: Annotated[NotNegative, Unit("N")] = ScaledDefault(60.0)
    """Bound of it, in each direction."""

    @together
    def _releases_below_touch(self) -> None:
        if self.release_force >= self.touch_force:
            allowed = f"must be below touch_force = {self.touch_force}"
            raise misfit("release_force", self.release_force, allowed)
