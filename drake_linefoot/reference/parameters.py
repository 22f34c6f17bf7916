"""What the reference takes of the parameters of the MPC."""

from typing import Protocol

ECD = "ecd"
CONTACT_CONSISTENT = "contact_consistent"
SINGLE_BODY = "srbm"
SINGLE_BODY_MOMENTUM = "srbm_momentum"
MODELS = (ECD, CONTACT_CONSISTENT, SINGLE_BODY, SINGLE_BODY_MOMENTUM)


class ReferenceParameters(Protocol):
    """Model and knots, as `MpcParameters` has them."""

    model: str  # one of `MODELS`
    knots: int  # intervals of the horizon
    knot_step: float  # longest interval [s]
    period: float  # between two plans [s]

    @property
    def lead(self) -> float:
        """From the state a plan is made of to when it begins to be used [s]."""
