"""A short walk that is recorded once for all tests of the benchmark."""

from functools import cache

from drake_linefoot.benchmark import recording, scenarios
from drake_linefoot.scenario_edit import with_duration


@cache
def walk():
    """The shipped walk until its first steps."""
    return recording.record(with_duration(scenarios.walking(), 1.2))
