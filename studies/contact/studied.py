"""What is found in one recorded walk: scores of the choices, and both forms side by side."""

import time as clock
from collections.abc import Sequence
from typing import NamedTuple

from drake_linefoot.errors import LinefootError
from drake_linefoot.estimation.contact_parameters import EstimatorParameters
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.robot.humanoid import load_humanoid
from studies.contact.constrained import Compared, compare
from studies.contact.replayed import Score, observe
from studies.contact.thresholds import scored
from studies.contact.walks import recorded_walk

Job = tuple[Scenario, str, int]  # a walk, its kind, and its index there


class Studied(NamedTuple):
    """What is found in a walk."""

    kind: str  # one of `KINDS`
    number: int  # of the run within its group
    until: float  # [s]: its end, or the beginning of its fall
    scores: list[list[Score]]  # of both feet, with each of the choices
    compared: Compared
    seconds: float  # of one processor, that it took


def study(tried: Sequence[EstimatorParameters], default: EstimatorParameters, job: Job) -> Studied:
    """Simulate a walk, and let the estimator see it again with each of `tried`."""
    begin = clock.process_time()
    walk, humanoid = recorded_walk(*job), load_humanoid(job[0].robot)
    seen = observe(humanoid, walk.run, walk.end)
    until = float(walk.run.time[walk.end - 1])
    scores = scored(humanoid, walk, seen, tried)
    compared = compare(humanoid, walk, seen, default)
    return Studied(*job[1:], until, scores, compared, clock.process_time() - begin)


def lost(job: Job, error: str) -> Studied:
    """Break off for a walk whose process crashed or took too long.

    Raises:
        LinefootError: of it; without a walk the kinds are not what the page says.
    """
    raise LinefootError(f"{job[0].name}: {error}")
