"""The page on robustness, as Markdown for the documentation."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from drake_linefoot.lab.results.page import render
from drake_linefoot.lab.results.tables import NOTHING, VERDICTS, number
from drake_linefoot.lab.sweep.rows import Row
from drake_linefoot.lab.sweep.statistics import worst
from studies.robustness.summary import ENOUGH, FALSE_RATE, LATENCY, THRESHOLDS

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
        bars=threshold_rows(summary),
        causes=list(dict.fromkeys(c for g in summary["groups"].values() for c in g["causes"])),
        value=_value,
        number=number,
        falls=_falls(rows),
        maps=maps,
        viable=viable,
    )


def threshold_rows(summary: Mapping[str, Any]) -> list[list[str]]:
    """Return a row for each threshold: key, what, value, interval, threshold, met."""
    rows = []
    for one in THRESHOLDS:
        group, between, asked = summary["groups"].get(one.key, {}), NOTHING, NOTHING
        if group.get("n"):
            between = f"{100.0 * group['low']:.1f} to {100.0 * group['high']:.1f} %"
        if one.least is not None:
            asked = f"at least {100.0 * one.least:.4g} %"
        elif one.most is not None:
            asked = "at most " + _value(one.key, one.most)
        met = NOTHING if summary[one.key] is None else VERDICTS[summary["bars"][one.key]["met"]]
        value = _value(one.key, summary[one.key])
        rows.append([f"`{one.key}`", one.what, value, between, asked, met])
    return rows


def _value(key: str, value: float | None) -> str:
    if value is None:
        return NOTHING
    if key == LATENCY:
        return f"{value:.3g} ms"
    return f"{100.0 * value:.3g} %" if key == FALSE_RATE else f"{100.0 * value:.1f} %"


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
