"""Parameters of the contact estimator."""

from dataclasses import dataclass

PSEUDOINVERSE = "pseudoinverse"
CONSTRAINED = "constrained"
METHODS = (PSEUDOINVERSE, CONSTRAINED)


@dataclass
class EstimatorParameters:
    """How contacts are estimated. Units in brackets."""

    filter_constant: float = 0.8  # [-] gamma of (21), per tick; 0 is unfiltered
    method: str = PSEUDOINVERSE  # "pseudoinverse", or "constrained": the program (22)
    touch_force: float = 30.0  # [N] normal force above which a foot counts as standing
    release_force: float = 12.0  # [N] normal force below which it counts as in the air
    friction: float = 0.8  # [-] in the cone of the constrained form
