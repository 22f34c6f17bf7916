"""The report of a sweep: one page that opens from disk and needs no network."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from drake_linefoot.lab.results.page import render
from drake_linefoot.lab.sweep.file import SEED, Sweep
from drake_linefoot.lab.sweep.maps import described, map_figures
from drake_linefoot.lab.sweep.rows import Row
from drake_linefoot.lab.sweep.statistics import tilt

RATES = (
    *("", "runs", "upright", "rate", "95 % interval", "fell", "no outcome", "done again"),
    "won, lost (p)",
)
NOTHING = "-"
TEMPLATES = Path(__file__).parent / "templates"


def sweep_page(
    sweep: Sweep,
    rows: Mapping[str, Sequence[Row]],
    summary: dict[str, Any],
    units: Mapping[str, str],
    worst: Sequence[tuple[Row, str]],
    file: Path,
) -> str:
    """Return the report.

    Args:
        sweep: that was carried out.
        rows: of each group, by its name.
        summary: what `summary.json` holds.
        units: of the sampled values, by dotted path.
        worst: the worst runs, each with the file of its replay, empty where there is none.
        file: of the sweep.
    """
    groups = summary["groups"]
    return render(
        "sweep.html.j2",
        TEMPLATES,
        title=f"{sweep.name}, sweep of drake_linefoot",
        sweep=sweep,
        made_with=summary["made_with"],
        done=sum(map(len, rows.values())),
        planned=sum(sweep.runs.values()),
        rates=[rate_row(*item) for item in groups.items()],
        rates_head=RATES,
        groups=groups,
        causes=list(dict.fromkeys(cause for g in groups.values() for cause in g["causes"])),
        worst=[(_described(row), replay) for row, replay in worst],
        figures=map_figures({name: some for name, some in rows.items() if some}, units),
        units=units,
        text=file.read_text(encoding="utf-8"),
    )


def rate_row(name: str, group: Mapping[str, Any]) -> tuple[str, ...]:
    """Return a group as a row of `RATES`."""
    rate, between = NOTHING, NOTHING
    if group["n"]:
        rate = f"{100.0 * group['rate']:.1f} %"
        between = f"{100.0 * group['low']:.1f} to {100.0 * group['high']:.1f} %"
    counts = (str(group[key]) for key in ("fell", "errors", "redone"))
    compared = NOTHING
    if (one := group.get("against")) is not None:
        compared = f"{one['won']}, {one['lost']} ({one['p']:.2g})"
    return name, str(group["n"]), str(group["upright"]), rate, between, *counts, compared


def _described(row: Row) -> tuple[str, ...]:
    """Return a row of the table of the worst runs."""
    outcome = row["cause"]
    if row["fell"]:
        outcome = f"{row['fall_reason']} at {row['fall_time']:.2f} s"
        outcome += f"; {row['cause']}: {row['fall_indicators']}"
    values = ", ".join(described({p: v for p, v in row["sampled"].items() if p != SEED}))
    name, seed = f"{row['group']} {row['index']}", str(row["seed"])
    return name, seed, outcome, f"{math.degrees(tilt(row)):.1f} deg", values
