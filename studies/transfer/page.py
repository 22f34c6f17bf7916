"""Bars and page of the walks in two simulators."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from drake_linefoot.lab.results.page import render
from drake_linefoot.lab.results.tables import number
from studies.common import paired
from studies.common.bars import HEAD, Asked, bar_rows, judged, loss
from studies.common.types import Data
from studies.transfer.cases import CASES, DRAKE, ESTIMATE, LATE, MUJOCO, MUJOCO_2, OWN, PLANTS
from studies.transfer.robots import in_both

BESIDE = {  # entry of the summary: the ways in which draws of the sweep are simulated
    "pairs": paired.SIMULATORS,
    paired.OWN: (paired.SIMULATORS[0], paired.OWN),
    paired.LATE: (paired.SIMULATORS[0], paired.LATE),
}
MOST = {paired.OWN: 20, paired.LATE: 50}  # draws of each group; of others as many as asked for
OURS = [name for name in CASES if name not in (ESTIMATE, LATE) and "push" not in name]
FELL = Asked("runs that are not upright", 0, most=True)
LARGEST = {  # of a column of some cases in a plant
    "speed_error": (
        Asked("error of the speed in MuJoCo", 0.03, "m/s", True),
        (MUJOCO, "speed_error", OURS),
    ),
    "own_contacts": (
        Asked("likewise with its own contacts", 0.05, "m/s", True),
        (OWN, "speed_error", OURS),
    ),
    "on_estimate": (
        Asked("likewise on the estimate", 0.05, "m/s", True),
        (MUJOCO, "speed_error", [ESTIMATE]),
    ),
    "late_torques": (
        Asked("likewise with 5 ms of delay", 0.05, "m/s", True),
        (MUJOCO, "speed_error", [LATE]),
    ),
    "false_contacts": (
        Asked("false contacts of a walk in MuJoCo, without pushes", 0, most=True),
        (MUJOCO, "false_contacts", OURS),
    ),
    "latency": (
        Asked("latency of contacts in MuJoCo", 5.0, "ms", True),
        (MUJOCO, "contact_latency", OURS),
    ),
}
RATE = Asked("simulated seconds a CPU second: MuJoCo at 2 ms over Drake at 1 ms", 2.5)
FEWER = Asked("fewer upright in MuJoCo than in Drake, of the same draws", 5.0, "points", True)
WALK = Asked("robots of the zoo that walk in both", 4)
TABLES = (  # of a column of `walked`: title, name, format
    ("Error of the speed [m/s]", "speed_error", ".3f"),
    ("Latency of contacts, median [ms]", "contact_latency", ".0f"),
    ("Largest tilt of the torso [rad]", "tilt", ".3f"),
    ("Largest force on a foot, of the robot's weight", "force", ".2f"),
    ("False contacts", "false_contacts", "d"),
    ("Simulated seconds a CPU second", "rate", ".2f"),
)


def bars_of(
    rows: Sequence[Mapping[str, Any]], pairs: Mapping[str, Data], others: Sequence[Data]
) -> dict[str, Data]:
    """Return what is asked, by key, see `judged`; of each group of the sweep, the loss of pairs.

    Args:
        rows: of `walked`.
        pairs: see `shares`.
        others: robots, of `robots.walked`.
    """

    def of(plant: str, name: str, cases: Sequence[str] = tuple(CASES)) -> list[float]:
        mine = [row[name] for row in rows if row["plant"] == plant and row["case"] in cases]
        return [value for value in mine if value is not None]

    rates = [of(plant, "rate") for plant in (MUJOCO_2, DRAKE)]
    fast, base = (sum(rate) / len(rate) if rate else None for rate in rates)
    return {
        "fell": judged(FELL, sum(not row["upright"] for row in rows)),
        **{
            key: judged(asked, max(of(*where), default=None))
            for key, (asked, where) in LARGEST.items()
        },
        "rate": judged(RATE, fast / base if fast and base else None),
        **{
            group: loss(FEWER, one["mujoco_lost"], one["mujoco_won"], one["runs"])
            for group, one in pairs.items()
        },
        "robots": judged(WALK, len(in_both(others))),
    }


def page_of(summary: Data) -> str:
    """Return the page of what `summary.json` holds."""
    tables: dict[str, list[list[str]]] = {}
    for title, name, spec in TABLES:
        tables[title] = []
        for case in CASES:
            at = {row["plant"]: row for row in summary["runs"] if row["case"] == case}
            cells = [
                number(at[plant][name], spec) if at[plant]["upright"] else "fell"
                for plant in PLANTS
            ]
            tables[title].append([case, *cells])
    return render(
        "index.md.j2",
        Path(__file__).parent,
        summary=summary,
        head=HEAD,
        bars=bar_rows(summary["bars"]),
        plants=["", *PLANTS],
        tables=tables,
        beside=BESIDE,
        number=number,
    )
