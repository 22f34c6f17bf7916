"""A quick form of the study."""

from studies.common.stamp import Probed
from studies.running.cases import Trial
from studies.running.trial import tried

SPEED, TIME = "2", 4.0  # [m/s], [s]


def probe() -> dict[str, Probed]:
    """Return what came of a run at 2 m/s, for a while."""
    row = tried(Trial("run_forward", SPEED, 0, TIME))
    found = {"upright": Probed(float(row["upright"]), 0.0)}
    if row["measured"] and row["gait"]:
        found["speed_m_s"] = Probed(row["measured"][0], 0.04)
        found["flight_s"] = Probed(row["gait"]["flight_s"] or 0.0, 0.005)
        found["tilt_rad"] = Probed(row["tilt"], 0.03)
    return found
