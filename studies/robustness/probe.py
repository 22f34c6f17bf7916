"""A quick form of the study."""

from drake_linefoot.lab.results.judge import upright
from drake_linefoot.lab.sweep.file import Sweep
from drake_linefoot.lab.sweep.jobs import scenario_of
from studies.common.command import SWEEPS
from studies.common.stamp import Probed
from studies.common.sweeps import sweep_of
from studies.common.trial import outcome_of

GROUPS = ("wide_push_10", "wide_slope_10")


def probe() -> dict[str, Probed]:
    """Return what came of the first run of some groups."""
    sweep = sweep_of(SWEEPS[0])
    return {
        f"{group}_{name}": number
        for group in GROUPS
        for name, number in first_run(sweep, group, 0.03).items()
    }


def first_run(sweep: Sweep, group: str, within: float) -> dict[str, Probed]:
    """Return what came of the first run of a group; its speed may be off by `within` [m/s]."""
    outcome = outcome_of(scenario_of(sweep, group, 0))
    found = {"upright": Probed(float(upright(outcome)), 0.0)}
    if outcome["speed_error"] is not None:
        found["speed_error_m_s"] = Probed(outcome["speed_error"], within)
    return found
