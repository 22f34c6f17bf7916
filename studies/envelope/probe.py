"""A quick form of the study."""

from functools import cache

from drake_linefoot.lab.scenario.load import dump_scenario
from studies.common.runs import paper_scenario
from studies.common.stamp import Probed
from studies.common.trial import walk
from studies.envelope.envelope import QUICK_DURATION, try_command, unlimited

COMMAND = (1.2, 0.0, 0.0)  # forward, left [m/s], turn rate [rad/s]


@cache
def probe() -> dict[str, Probed]:
    """Return whether a fast walk is walked, and how fast."""
    made = walk(unlimited(paper_scenario(False)), COMMAND, QUICK_DURATION)
    row = try_command((dump_scenario(made), COMMAND))
    speed = row["measured"][0] if row["measured"] else 0.0
    return {"held": Probed(float(row["held"]), 0.0), "speed_m_s": Probed(speed, 0.05)}
