"""A short walk that is recorded once for all tests of the benchmark."""

from functools import cache

from drake_linefoot.lab.scenario.edit import with_duration
from studies.bench.measures import Effort
from studies.common import recorder
from studies.common.runs import paper_scenario

LEAST = Effort(True, 2, 1, 1, 1, 1, 1, 1, None)  # of the benchmark that measures everything


@cache
def walk():
    """The shipped walk until its first steps."""
    return recorder.record(with_duration(paper_scenario(quick=False), 1.2))
