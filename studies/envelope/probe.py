"""A quick form of the study."""

from functools import cache

from studies.common.runs import paper_scenario
from studies.common.stamp import Probed
from studies.envelope.envelope import QUICK_DURATION
from studies.envelope.walks import Attempt, attempted

SPEED = 1.2  # [m/s], forward


@cache
def probe() -> dict[str, Probed]:
    """Return whether a fast walk is walked, and how fast."""
    own = paper_scenario(False)
    row = attempted(Attempt(own.mpc.model, "forward", SPEED, own.seed, QUICK_DURATION))
    speed = row["measured"][0] if row["measured"] else 0.0
    return {"held": Probed(float(row["held"]), 0.0), "speed_m_s": Probed(speed, 0.05)}
