"""What the reference takes of the parameters of the MPC."""

from typing import Protocol

ECD = "ecd"
SINGLE_BODY = "srbm"
MODELS = (ECD, SINGLE_BODY)


class ReferenceParameters(Protocol):
    """Model and knots, as `MpcParameters` has them."""

    model: str  # one of `MODELS`
    knots: int  # intervals of the horizon
    knot_step: float  # longest interval [s]

    @property
    def lead(self) -> float:
        """From the state a plan is made of to when it begins to be used [s]."""
