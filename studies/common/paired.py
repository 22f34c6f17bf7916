"""The sweep of robustness with the same draws in two simulators, side by side."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from drake_linefoot.lab.results.judge import judge, upright
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.sweep.file import load_sweep
from drake_linefoot.lab.sweep.jobs import scenario_of
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from studies.common.command import SWEEPS
from studies.common.types import Data

SIMULATORS = ("drake", "mujoco")
LIMIT = 3600.0  # [s] of wall time of a run


@dataclass(frozen=True)
class Draw:
    """A run of a group of the sweep in a simulator."""

    group: str
    index: int
    simulator: str

    @property
    def key(self) -> str:
        """What makes it one run."""
        return f"{self.group} {self.index} {self.simulator}"


def draws(runs: int) -> Iterator[Draw]:
    """Yield what there is to simulate, both simulators of a draw after each other."""
    groups = load_sweep(SWEEPS[0]).groups
    for index in range(runs):
        for group in groups:
            yield from (Draw(group.name, index, simulator) for simulator in SIMULATORS)


def drawn(draw: Draw) -> Data:
    """Simulate and judge a draw."""
    made = scenario_of(load_sweep(SWEEPS[0]), draw.group, draw.index)
    made = replace(made, plant=replace(made.plant, simulator=draw.simulator))
    loop = build_closed_loop(made)
    outcome = judge(simulate(loop))
    loop.recorder.keep_last(0)
    stays = upright(outcome)
    return row_of(draw, stays, "" if stays else outcome["fall_reason"] or outcome["cause"])


def row_of(draw: Draw, stays: bool, reason: str) -> Data:
    """Return the row of a draw that stayed upright or, for a reason, did not."""
    named = {"key": draw.key, "group": draw.group, "simulator": draw.simulator}
    return {**named, "upright": stays, "reason": reason}


def lost(draw: Draw, error: str) -> Data:
    """Return the row of a draw whose process crashed or took too long."""
    return row_of(draw, False, error)


def limit(_: Draw) -> float:
    """Return how long a draw may take [s]."""
    return LIMIT


def shares(rows: Sequence[Mapping[str, object]]) -> dict[str, Data]:
    """Return of each group how many `runs` there are, and how many stayed upright in each."""
    found: dict[str, Data] = {}
    for row in rows:
        of = found.setdefault(str(row["group"]), {"runs": 0, **dict.fromkeys(SIMULATORS, 0)})
        of["runs"] += row["simulator"] == SIMULATORS[0]
        of[str(row["simulator"])] += bool(row["upright"])
    return found
