"""The report of a sweep: one page that opens from disk and needs no network."""

from __future__ import annotations

import html
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from drake_linefoot.sweep.file import SEED, Sweep
from drake_linefoot.sweep.maps import label, map_figures, short
from drake_linefoot.sweep.rows import Row
from drake_linefoot.sweep.statistics import tilt
from drake_linefoot.visualization.plot_page import plot_page, plots, table

RATES = ("", "runs", "upright", "rate", "95 % interval", "fell", "no outcome", "done again")
NOTHING = "-"
LEADING = "leading cause"

_BODY = """\
<h1>%(name)s</h1>
<p class="small">linefoot sweep: scenario %(scenario)s, seed %(seed)s, %(runs)s runs of each group;
%(made_with)s</p>
%(missing)s
<h2>Success rates</h2>
%(rates)s
<p class="small">Upright: the run went on to its end without a fall. A run without an outcome
counts as not upright. Intervals are Wilson's.</p>
<h2>What the others came to</h2>
%(causes)s
<h2>Worst runs</h2>
%(worst)s
<p class="small">The earliest falls, then the largest tilt.</p>
<p class="small">Plots: drag to zoom, double-click to see all. Parameters are in the order in
which they tell of success.</p>
%(plots)s
<h2>What is drawn</h2>
%(drawn)s
<h2>Sweep</h2>
<pre>%(text)s</pre>"""


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
        units: of what is drawn, by dotted path.
        worst: the worst runs, each with the file of its replay, empty where there is none.
        file: of the sweep.
    """
    figures = map_figures({name: some for name, some in rows.items() if some}, units)
    groups = summary["groups"]
    done, planned = sum(map(len, rows.values())), sweep.runs * len(sweep.groups)
    missing = ""
    if done < planned:
        missing = f'<p class="fell">{done} of {planned} runs are done.</p>'
    body = _BODY % {
        "name": html.escape(sweep.name),
        "scenario": html.escape(sweep.scenario),
        "seed": sweep.seed,
        "runs": sweep.runs,
        "made_with": html.escape(", ".join(f"{k} {v}" for k, v in summary["made_with"].items())),
        "missing": missing,
        "rates": table([rate_row(*item) for item in groups.items()], RATES, numbers=True),
        "causes": _causes(groups),
        "worst": _worst(worst),
        "plots": plots(list(figures)),
        "drawn": _drawn(sweep, units),
        "text": html.escape(file.read_text(encoding="utf-8")),
    }
    return plot_page(f"{sweep.name}, sweep of drake_linefoot", body, figures)


def rate_row(name: str, group: Mapping[str, Any]) -> tuple[str, ...]:
    """Return a group as a row of `RATES`."""
    rate, between = NOTHING, NOTHING
    if group["n"]:
        rate = f"{100.0 * group['rate']:.1f} %"
        between = f"{100.0 * group['low']:.1f} to {100.0 * group['high']:.1f} %"
    counts = (str(group[key]) for key in ("fell", "errors", "redone"))
    return name, str(group["n"]), str(group["upright"]), rate, between, *counts


def _causes(groups: Mapping[str, Mapping[str, Any]]) -> str:
    """Return how many runs of each group came to each cause."""
    causes = list(dict.fromkeys(cause for g in groups.values() for cause in g["causes"]))
    if not causes:
        return "<p>Every run was upright.</p>"
    rows = [(c, *(str(g["causes"].get(c, 0)) for g in groups.values())) for c in causes]
    rows.append((LEADING, *(next(iter(g["causes"]), NOTHING) for g in groups.values())))
    return table(rows, ("", *groups), numbers=True)


def _worst(worst: Sequence[tuple[Row, str]]) -> str:
    """Return the worst runs with links to their replays."""
    if not worst:
        return "<p>None.</p>"
    head = ("run", "seed", "came to", "largest tilt", "drawn", "replay")
    lines = ["<table>", "<tr>" + "".join(f"<th>{name}</th>" for name in head) + "</tr>"]
    for row, replay in worst:
        came_to = row["cause"]
        if row["fell"]:
            came_to = f"{row['fall_reason']} at {row['fall_time']:.2f} s"
            came_to += f"; {row['cause']}: {row['symptoms']}"
        drawn = {path: short(value) for path, value in row["sampled"].items() if path != SEED}
        values = ", ".join(f"{path} = {value}" for path, value in drawn.items())
        cells = [
            f"{row['group']} {row['index']}",
            str(row["seed"]),
            came_to,
            f"{math.degrees(tilt(row)):.1f} deg",
            values,
        ]
        link = f'<a href="{html.escape(replay)}">replay</a>' if replay else NOTHING
        shown = "".join(f"<td>{html.escape(cell)}</td>" for cell in cells)
        lines.append(f"<tr>{shown}<td>{link}</td></tr>")
    return "\n".join([*lines, "</table>"])


def _drawn(sweep: Sweep, units: Mapping[str, str]) -> str:
    """Return the distributions of each group."""
    rows = []
    for group in sweep.groups:
        for path, distribution in group.sample.items():
            values = ", ".join(map(str, distribution.values))
            clip = "" if distribution.clip is None else f", within {list(distribution.clip)}"
            how = f"{distribution.kind} of {values}{clip}"
            rows.append((group.name, label(path, units), how))
    return table(rows, ("group", "parameter", "distribution"))
