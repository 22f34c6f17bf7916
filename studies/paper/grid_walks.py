"""The walks of the grid, each kept when it is done: together they take some hours."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from studies.common.command import DOCS
from studies.common.pool import PROCESSES
from studies.common.trial import lost, tried
from studies.common.trials import Trials
from studies.common.types import Data

DONE = DOCS / "paper" / "grid.jsonl"  # where they are kept, one a line
LIMIT = 3600.0  # [s] of wall time of a walk


@dataclass(frozen=True)
class Walk:
    """A walk of one controller at one point."""

    key: str  # what makes it one walk
    label: tuple[int, str, str]  # place of the point, weights, model
    scenario: str  # YAML text


def walked(jobs: Sequence[Walk], done: Path) -> list[Data]:
    """Return `judge_walk` of each walk, labelled; of those that a file has the kept one."""
    trials = Trials(done, _tried, _lost, lambda _: LIMIT, PROCESSES)
    rows = trials.begun(jobs, fresh=False)
    for _ in trials.carried_out(jobs, rows):
        pass
    return [rows[job.key] for job in jobs]


def _tried(job: Walk) -> Data:
    return tried((job.label, job.scenario)) | {"key": job.key}


def _lost(job: Walk, error: str) -> Data:
    return lost((job.label, job.scenario), error) | {"key": job.key}
