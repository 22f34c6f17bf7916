"""The page on robustness, as Markdown for the documentation."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from drake_linefoot.lab.results.page import render
from drake_linefoot.lab.results.tables import number
from drake_linefoot.lab.sweep.rows import Row
from drake_linefoot.lab.sweep.statistics import worst
from studies.common.bars import HEAD, bar_rows
from studies.robustness.summary import ENOUGH

FALLS = 3  # of each group that are listed
SEEN = 2  # fall indicators of each


def page_of(
    summary: Mapping[str, Any],
    rows: Mapping[str, Sequence[Row]],
    maps: Mapping[str, str],
    viable: str | None = None,
) -> str:
    """Return the page; `maps` and `viable` are files of pictures, relative to it."""
    return render(
        "index.md.j2",
        Path(__file__).parent,
        summary=summary,
        enough=ENOUGH,
        bars=bar_rows(summary["bars"]),
        head=HEAD,
        causes=list(dict.fromkeys(c for g in summary["groups"].values() for c in g["causes"])),
        number=number,
        falls=_falls(rows),
        maps=maps,
        viable=viable,
    )


def _falls(rows: Mapping[str, Sequence[Row]]) -> list[list[str]]:
    lines = []
    for name, some in rows.items():
        for row in worst([row for row in some if row["fell"]], FALLS):
            seen = [
                one + ")" for one in row["fall_indicators"].split("), ")[:-1][:SEEN]
            ]  # last: swings
            when = f"{row['fall_time']:.2f} s"
            lines.append([f"{name} {row['index']}", when, row["cause"], ", ".join(seen)])
    return lines
