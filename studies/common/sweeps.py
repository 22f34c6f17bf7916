"""Sweeps that studies take draws of."""

from functools import cache
from pathlib import Path

from drake_linefoot.lab.results.judge import upright
from drake_linefoot.lab.sweep.file import Sweep, load_sweep
from drake_linefoot.lab.sweep.jobs import scenario_of
from studies.common.stamp import Probed
from studies.common.trial import outcome_of


@cache
def sweep_of(file: Path) -> Sweep:
    """Return a sweep; a process reads it once, as the ends of all distributions are checked.

    Raises:
        ScenarioError: as `load_sweep`.
    """
    return load_sweep(file)


def first_run(sweep: Sweep, group: str, within: float) -> dict[str, Probed]:
    """Return what came of the first run of a group; its speed may be off by `within` [m/s]."""
    outcome = outcome_of(scenario_of(sweep, group, 0))
    found = {"upright": Probed(float(upright(outcome)), 0.0)}
    if outcome["speed_error"] is not None:
        found["speed_error_m_s"] = Probed(outcome["speed_error"], within)
    return found
