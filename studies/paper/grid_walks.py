"""The walks of the grid, each kept when it is done: together they take some hours."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from drake_linefoot.lab.scenario.load import parse_scenario
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from studies.common.command import DOCS
from studies.common.pool import PROCESSES
from studies.common.trial import judge_walk, lost
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
    loop = build_closed_loop(parse_scenario(job.scenario))
    row = judge_walk(simulate(loop))
    loop.recorder.keep_last(0)  # Python 3.11 does not free a loop, so 2,880 recordings would stay
    return {"key": job.key, "label": job.label, **row}


def _lost(job: Walk, error: str) -> Data:
    return lost((job.label, job.scenario), error) | {"key": job.key}
