"""What a controller is made of: the parameters of its blocks, and the tick that they share."""

from dataclasses import dataclass, field
from typing import Annotated, Protocol

from pydantic import AfterValidator

from drake_linefoot.estimation.contact_parameters import EstimatorParameters
from drake_linefoot.fields import Number, Unit
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.mpc.parameters import MpcParameters
from drake_linefoot.parameters import Parameters
from drake_linefoot.wbc.parameters import WbcParameters

TICKS = (0.001, 0.002)  # [s] of plant, estimator, gait and whole-body controller


def is_tick(period: float) -> float:
    """Return a period that the controller can have.

    Raises:
        ValueError: it is another one.
    """
    if period not in TICKS:
        raise ValueError("must be 0.001 or 0.002 s, the period of the whole controller")
    return period


class ParametersOfBlocks(Protocol):
    """What `build_controller` reads: a `ControllerParameters` has it, and a scenario of the lab."""

    estimator: EstimatorParameters
    gait: GaitParameters
    mpc: MpcParameters
    wbc: WbcParameters

    @property
    def period(self) -> float:
        """Of estimator, gait and whole-body controller, and of the plant's steps [s]."""


@dataclass
class ControllerParameters(Parameters):
    """Parameters of a controller, for a plant of one's own."""

    period: Annotated[Number, AfterValidator(is_tick), Unit("s")] = 0.001
    """Of estimator, gait and whole-body controller, and of the plant's steps."""
    estimator: EstimatorParameters = field(default_factory=EstimatorParameters)
    gait: GaitParameters = field(default_factory=GaitParameters)
    mpc: MpcParameters = field(default_factory=MpcParameters)
    wbc: WbcParameters = field(default_factory=WbcParameters)
