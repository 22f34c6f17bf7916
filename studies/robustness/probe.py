"""A quick form of the study."""

from drake_linefoot.lab.results.judge import upright
from drake_linefoot.lab.sweep.jobs import scenario_of
from studies.common.command import SWEEPS
from studies.common.stamp import Probed
from studies.common.sweeps import sweep_of
from studies.common.trial import outcome_of

GROUPS = ("wide_push_10", "wide_slope_10")


def probe() -> dict[str, Probed]:
    """Return what came of the first run of some groups."""
    sweep, found = sweep_of(SWEEPS[0]), {}
    for group in GROUPS:
        outcome = outcome_of(scenario_of(sweep, group, 0))
        found[f"{group}_upright"] = Probed(float(upright(outcome)), 0.0)
        if outcome["speed_error"] is not None:
            found[f"{group}_speed_error_m_s"] = Probed(outcome["speed_error"], 0.03)
    return found
