"""The page on robustness, as Markdown for the documentation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from drake_linefoot.robustness.summary import (
    BARS,
    ENOUGH,
    FALSE_RATE,
    LATENCY,
    RATES,
    Bar,
)
from drake_linefoot.sweep.file import SEED
from drake_linefoot.sweep.maps import short
from drake_linefoot.sweep.rows import Row
from drake_linefoot.sweep.statistics import worst

NOTHING = "-"
FALLS = 3  # of each group that are listed

_PAGE = """\
# Robustness

Made from the tables of the sweeps by `{command}`; do not edit.

{runs}
{versions}. Seeds of the sweeps: {seeds}. A run is upright when it went on to its end at
{duration:.4g} s without a fall; one without an outcome counts as not upright. Intervals are
Wilson's, at 95 %. The sweeps are [nominal.yaml](../../examples/sweeps/nominal.yaml) and
[robustness.yaml](../../examples/sweeps/robustness.yaml); the numbers are in
[summary.json](summary.json).

{bars}

{paired}![Success rates](rates.png)

## Contacts

Of the runs that stayed upright: the estimator against the simulator. Latency is the median over the
runs of each one's median.

{contacts}

## Why the others fell

Number of runs by [cause](../sweeps.md#why-runs-fall).

{causes}

The earliest falls of each group:

{falls}

## Over what was drawn

Parameters are in the order in which they tell of success.

{maps}
"""


def page_of(
    summary: Mapping[str, Any], rows: Mapping[str, Sequence[Row]], maps: Mapping[str, str]
) -> str:
    """Return the page.

    Args:
        summary: what `summary.json` holds.
        rows: of each group.
        maps: files of the maps by group, relative to the page.
    """
    made_with = ", ".join(f"{name} {value}" for name, value in summary["made_with"].items())
    seeds = ", ".join(f"{name} {seed}" for name, seed in summary["sweeps"].items())
    runs = f"{summary['runs']} runs of each group."
    if summary["runs"] < ENOUGH:
        runs = f"**A quick look: {summary['runs']} runs of each group, the bars are for {ENOUGH}.**"
    return _PAGE.format(
        command=summary["command"],
        runs=runs,
        versions=made_with,
        seeds=seeds,
        duration=summary["duration_s"],
        bars=_bars(summary),
        paired=_paired(summary["paired"]),
        contacts=_contacts(summary["groups"]),
        causes=_causes(summary["groups"]),
        falls=_falls(rows),
        maps="\n\n".join(f"![{name}]({file})" for name, file in maps.items()),
    )


def table(head: Sequence[str], rows: Sequence[Sequence[str]], numbers: bool = True) -> str:
    """Return a table in Markdown; with `numbers` all columns but the first are for them."""
    side = "---:" if numbers else "---"
    lines = [head, ["---", *[side] * (len(head) - 1)], *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def bar_rows(summary: Mapping[str, Any]) -> list[list[str]]:
    """Return a row for each bar: key, what, value, interval, bar, met."""
    return [_bar_row(bar, summary) for bar in BARS]


def _bar_row(bar: Bar, summary: Mapping[str, Any]) -> list[str]:
    value, judged = summary[bar.key], summary["bars"][bar.key]
    group = summary["groups"].get(bar.key, {})
    between, asked = NOTHING, "reported"
    if group.get("n"):
        between = f"{100.0 * group['low']:.1f} to {100.0 * group['high']:.1f} %"
    if bar.key == "rough_no_estimator":
        asked = "clearly less than `rough`"
    elif bar.least is not None:
        asked = f"at least {100.0 * bar.least:.4g} %"
    elif bar.most is not None:
        asked = "at most " + _value(bar.key, bar.most)
    met = {True: "yes", False: "**NO**", None: NOTHING}[judged["met"]]
    return [f"`{bar.key}`", bar.what, _value(bar.key, value), between, asked, met]


def _value(key: str, value: float | None) -> str:
    if value is None:
        return NOTHING
    if key == LATENCY:
        return f"{value:.3g} ms"
    return f"{100.0 * value:.3g} %" if key == FALSE_RATE else f"{100.0 * value:.1f} %"


def _bars(summary: Mapping[str, Any]) -> str:
    return table(("", "", "found", "95 % interval", "bar", "met"), bar_rows(summary), False)


def _paired(found: Mapping[str, Any]) -> str:
    """Return what comparing `rough` and `rough_no_estimator` run by run says, or nothing."""
    if not found["pairs"]:
        return ""
    return (
        "Clearly less means that the intervals do not meet. Run by run, over the same tiles with\n"
        f"the same command, {found['first_only']} of {found['pairs']} stayed upright only with the "
        f"estimator and\n{found['second_only']} only without it: p = {found['p']:.2g} "
        "(McNemar's exact test).\n\n"
    )


def _contacts(groups: Mapping[str, Mapping[str, Any]]) -> str:
    rows = []
    for name, group in groups.items():
        shown = [_value(key, group[key]) for key in (LATENCY, FALSE_RATE)]
        missed = _value(FALSE_RATE, group["missed_contact_rate"])
        rows.append([name, str(group["swings"]), *shown, missed])
    head = ("", "swings", "latency, median", "false contacts per swing", "missed per touchdown")
    return table(head, rows)


def _causes(groups: Mapping[str, Mapping[str, Any]]) -> str:
    causes = list(dict.fromkeys(cause for g in groups.values() for cause in g["causes"]))
    if not causes:
        return "Every run was upright."
    rows = [
        [name, *(str(g["causes"].get(c, 0)) for c in causes), next(iter(g["causes"]), NOTHING)]
        for name, g in groups.items()
    ]
    return table(("", *causes, "leading"), rows)


def _falls(rows: Mapping[str, Sequence[Row]]) -> str:
    lines = []
    for name, some in rows.items():
        for row in worst([row for row in some if row["fell"]], FALLS):
            drawn = {path: short(v) for path, v in row["sampled"].items() if path != SEED}
            said = ", ".join(f"{path} = {value}" for path, value in drawn.items())
            when = f"{row['fall_time']:.2f} s"
            lines.append([f"{name} {row['index']}", when, row["cause"], row["symptoms"], said])
    if not lines:
        return "None."
    return table(
        ("run", "fell at", "cause", "what was seen, from the onset", "drawn"), lines, False
    )


assert {bar.key for bar in BARS} == {*RATES, LATENCY, FALSE_RATE}
