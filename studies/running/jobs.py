"""All that is to be done: trials of the MIT Humanoid, and robots of the zoo."""

from collections.abc import Sequence

from drake_linefoot.errors import InputError
from studies.common.trials import FRESH
from studies.common.types import Data
from studies.running import robots
from studies.running.cases import Trial, trials
from studies.running.robots import Robot
from studies.running.trial import lost, tried

Job = Trial | Robot
LIMIT = {True: 4.0 * 3600.0, False: 3600.0}  # [s] of wall time of a robot, of a trial


def wanted(quick: bool, cases: Sequence[str] | None, first: int = FRESH) -> list[Job]:
    """Return what is to be tried, of some cases or of all.

    Raises:
        InputError: a case has no trial.
    """
    names = robots.QUICK_NAMES if quick else robots.NAMES
    every: list[tuple[str, Job]] = [(trial.case, trial) for trial in trials(quick, first)]
    every += [("robot", Robot(name, quick)) for name in names]
    known = dict.fromkeys(name for name, _ in every)
    for name in cases or ():
        if name not in known:
            raise InputError("studies.running", "--case", name, f"must be one of {list(known)}")
    return [job for name, job in every if not cases or name in cases]


def carry_out(job: Job) -> Data:
    """Return the row of a trial."""
    return robots.ran(job) if isinstance(job, Robot) else tried(job)


def limit_of(job: Job) -> float:
    """Return how long a trial may take [s] of wall time."""
    return LIMIT[isinstance(job, Robot)]


def missed(job: Job, error: str) -> Data:
    """Return the row of a trial whose process crashed or took too long."""
    if isinstance(job, Trial):
        return lost(job, error)
    nothing = {"speed": 0.0, "share": 0.0, "reason": error}
    return {"key": job.key, "case": "robot", "label": job.name, **nothing}
