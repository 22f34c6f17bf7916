"""A quick form of the study."""

from studies.common.command import SWEEPS
from studies.common.stamp import Probed
from studies.common.sweeps import first_run, sweep_of

GROUPS = ("wide_push_10", "wide_slope_10")


def probe() -> dict[str, Probed]:
    """Return what came of the first run of some groups."""
    sweep = sweep_of(SWEEPS[0])
    return {
        f"{group}_{name}": number
        for group in GROUPS
        for name, number in first_run(sweep, group, 0.03).items()
    }
