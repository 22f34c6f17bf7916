"""The sweep of robustness with the same draws in other contacts, with late plans, with a map."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import median
from typing import Any

from rich.console import Console

from drake_linefoot.lab.results.judge import upright
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.scenario.courses import TerrainParameters
from drake_linefoot.lab.scenario.schema import MujocoParameters
from drake_linefoot.lab.sweep.jobs import scenario_of
from studies.common.bars import compared
from studies.common.command import SWEEPS
from studies.common.published import published_rows
from studies.common.sweeps import sweep_of
from studies.common.trial import outcome_of
from studies.common.trials import Trials
from studies.common.types import Data

SIMULATORS = ("drake", "mujoco")
OWN = "own"  # in MuJoCo, in the contacts that it has by itself
LATE = "late"  # in Drake, each plan of the MPC used an update later
KNOWN = "known"  # in Drake, with a map of the ground
ALIKE = 10  # draws of a group that are compared before the others are taken to be the same
TILTS = ("roll_max", "pitch_max")
ITS_OWN = MujocoParameters("pyramidal", 1.0, [0.02, 1.0], [0.9, 0.95, 0.001, 0.5, 2.0])
LIMIT = 3600.0  # [s] of wall time of a run


@dataclass(frozen=True)
class Draw:
    """A run of a group of the sweep."""

    group: str
    index: int
    how: str  # one of `SIMULATORS`, `OWN`, `LATE` or `KNOWN`

    @property
    def key(self) -> str:
        """What makes it one run."""
        return f"{self.group} {self.index} {self.how}"


def kind(key: str) -> str:
    """Return how a draw is simulated, of its key; `case` for the key of another trial."""
    _, _, *how = key.split()
    return " ".join(how) or "case"


def draws(runs: int, ways: Sequence[str]) -> Iterator[Draw]:
    """Yield what there is to simulate, a draw in each way, see `Draw.how`, after the other."""
    groups = sweep_of(SWEEPS[0]).groups
    for index in range(runs):
        for group in groups:
            yield from (Draw(group.name, index, how) for how in ways)


def simulated(
    runs: int,
    ways: Sequence[str],
    rows: dict[str, Data],
    trials: Trials[Draw],
    screen: Console,
    alike: bool = False,
) -> list[Data]:
    """Return the rows of draws, those of Drake from what robustness has published where it has.

    With `alike` a group of which the first `ALIKE` draws come to the same in each way, to the last
    bit of the tilt, is simulated no further: its other rows are those of Drake, `taken`.

    Args:
        runs: draws of each group of the sweep.
        ways: see `draws`.
        rows: those that are kept, by key; the others are added.
        trials: that carry them out, see `trials_in`.
        screen: says how far it is.
        alike: whether draws may be taken to be the same.

    Raises:
        InputError: the published table cannot be read.
        OutputError: the file cannot be written.
    """
    some = list(draws(runs, ways))
    rows |= {key: row for key, row in known(some).items() if key not in rows}
    for stage in ([draw for draw in some if draw.index < ALIKE], some) if alike else (some,):
        for count, row in trials.carried_out(stage, rows):
            screen.print(f"{count} of {len(some)}: {row['key']} {row['reason']}", markup=False)
        rows |= taken(some, rows) if alike else {}
    return [rows[draw.key] for draw in some]


def taken(some: Sequence[Draw], rows: Mapping[str, Data]) -> dict[str, Data]:
    """Return rows that are not there, of groups whose first ones are as in Drake, from Drake's.

    Args:
        some: all draws.
        rows: those that are there, by key.
    """

    def there(draw: Draw) -> Data | None:
        return rows.get(replace(draw, how=SIMULATORS[0]).key)

    def of(row: Data | None) -> list[Any]:
        return [row and row[name] for name in ("upright", "reason", "tilt")]

    first = [draw for draw in some if draw.index < ALIKE]
    unlike = {draw.group for draw in first if of(rows.get(draw.key)) != of(there(draw))}
    return {
        draw.key: {**same, "key": draw.key, "how": draw.how, "taken": True}
        for draw in some
        if draw.key not in rows and draw.group not in unlike and (same := there(draw))
    }


def trials_in(file: Path, workers: int | None) -> Trials[Draw]:
    """Return what carries out draws and keeps them in a file."""
    return Trials(file, drawn, lost, lambda _: LIMIT, workers, kind)


def drawn(draw: Draw) -> Data:
    """Simulate and judge a draw."""
    return judged(draw, outcome_of(scenario(draw)))


def scenario(draw: Draw) -> Scenario:
    """Return what is simulated."""
    made = scenario_of(sweep_of(SWEEPS[0]), draw.group, draw.index)
    if draw.how == LATE:
        return replace(made, mpc=replace(made.mpc, late=True))
    if draw.how == KNOWN:
        return replace(made, terrain=TerrainParameters("scene"))
    if draw.how == OWN:
        return replace(made, plant=replace(made.plant, simulator="mujoco", mujoco=ITS_OWN))
    return replace(made, plant=replace(made.plant, simulator=draw.how))


def known(draws: Sequence[Draw]) -> dict[str, Data]:
    """Return the rows of draws in Drake that the study of robustness has published, by key."""
    rows = published_rows(sweep_of(SWEEPS[0]))
    return {
        draw.key: judged(draw, rows[draw.group, draw.index])
        for draw in draws
        if draw.how == SIMULATORS[0] and (draw.group, draw.index) in rows
    }


def judged(draw: Draw, outcome: Mapping[str, Any]) -> Data:
    """Return the row of a draw whose outcome is known."""
    stays = upright(outcome)
    row = row_of(draw, stays, "" if stays else outcome["fall_reason"] or outcome["cause"])
    return row | {"tilt": tilt(outcome)}


def tilt(outcome: Mapping[str, Any]) -> float | None:
    """Return the largest tilt of the torso in a run [rad]; None of one that was not upright."""
    return max(outcome[name] for name in TILTS) if upright(outcome) else None


def row_of(draw: Draw, stays: bool, reason: str) -> Data:
    """Return the row of a draw that stayed upright or, for a reason, did not."""
    named = {"key": draw.key, "group": draw.group, "index": draw.index, "how": draw.how}
    return {**named, "upright": stays, "reason": reason, "tilt": None}


def lost(draw: Draw, error: str) -> Data:
    """Return the row of a draw whose process crashed or took too long."""
    return row_of(draw, False, error)


def shares(rows: Sequence[Data]) -> dict[str, Data]:
    """Return of each group how many `runs` there are, and how they went in each way.

    Returns:
        By group and way, see `Draw.how`, how many stayed upright; with "_tilt" behind it the median
        of the largest tilt of those that did [rad], None without any; with "_lost" and "_won" the
        draws that stay upright in Drake alone, or there alone, and with "_taken" the rows that are.
    """
    found: dict[str, Data] = {}
    ways = dict.fromkeys(row["how"] for row in rows)
    for group in dict.fromkeys(row["group"] for row in rows):
        by = {
            how: [row for row in rows if (row["group"], row["how"]) == (group, how)] for how in ways
        }
        of: Data = {"runs": len(by[SIMULATORS[0]])}
        for how, some in by.items():
            tilts = [row["tilt"] for row in some if row["tilt"] is not None]
            of[how] = sum(bool(row["upright"]) for row in some)
            of[f"{how}_tilt"] = median(tilts) if tilts else None
            if how != SIMULATORS[0]:
                against = compared(some, by[SIMULATORS[0]])
                of |= {f"{how}_{which}": against[which] for which in ("lost", "won")}
                of[f"{how}_taken"] = sum(row.get("taken", False) for row in some)
        found[group] = of
    return found
