"""The tables of sweeps summarised, held against the thresholds."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from drake_linefoot.lab.results.judge import upright
from drake_linefoot.lab.sweep.rows import Row
from drake_linefoot.lab.sweep.statistics import CONFIDENCE, summarize_group
from studies.common.bars import Asked, judged, rate
from studies.common.types import Data

ENOUGH = 200  # runs of a group that the thresholds are for
LATENCY, FALSE_RATE = "latency_ms", "false_contact_rate"
NOMINAL, PUSHED, VIABLE = "wide", "wide_push", "viable_survived"
TOUR, PUNCHES, TOUR_MEDIAN = "punch_tour", "punches", "punches_survived"
RUN_TOUR, RUN_PUNCHES = "punch_tour_running", "punches_running"
HARDEST, IMPULSE = "hardest_survived", "pushes[0].impulse"


BARS = {
    NOMINAL: Asked("a new command every 2 s, no push", 99.5, "%"),
    "wide_push_10": Asked(
        "10 N s in 0.1 s, any direction and phase, while commands change", 98.0, "%"
    ),
    "wide_push_15": Asked("15 N s", 92.0, "%"),
    "wide_push_20": Asked("20 N s", 75.0, "%"),
    "stand_push_10": Asked("10 N s on a robot that stands", 98.0, "%"),
    "stand_push_15": Asked("15 N s on a robot that stands", 85.0, "%"),
    "wide_rough": Asked("random tiles up to 3 cm above or below their mean, blind", 97.0, "%"),
    "wide_rough_5": Asked("tiles up to 5 cm", 85.0, "%"),
    "wide_slippery": Asked("friction of 0.4, which the controller does not know", 97.0, "%"),
    "wide_slope_10": Asked("slope of 10 degrees, any heading, turning", 98.0, "%"),
    "wide_slope_15": Asked("slope of 15 degrees", 85.0, "%"),
    "wide_model_error": Asked("model errors, delays, noise and 10 N s together", 93.0, "%"),
    VIABLE: Asked(
        "of the pushes of 10 to 30 N s after which steps of its legs save a pendulum", 85.0, "%"
    ),
    LATENCY: Asked("detection latency without a push, median", 8.0, "ms", True),
    FALSE_RATE: Asked("false contacts per swing without a push", 1.0, "%", True),
}
RATES = tuple(BARS)[:-3]


def robustness_summary(
    groups: Mapping[str, Sequence[Row]], abouts: Sequence[Mapping[str, Any]], command: str
) -> dict[str, Any]:
    """Return what `summary.json` holds.

    Args:
        groups: the rows of each.
        abouts: what is said about each table: its name, seed, and what it was made with.
        command: that was given.

    Returns:
        For each of `RATES` the success rate [-], None without runs; `viable_survived` of the
        pushes of any size; `latency_ms` and `false_contact_rate` of walks that nothing disturbs;
        `bars`: what is asked of each of them; `groups`:
        `summarize_group` and `contact_figures` of each, and as `viable_survived` those runs of
        `wide_push`; `punches`, `punches_running`: of each tour, walking or running, most first;
        `punches_survived`: median of those walking, None without a tour; `hardest_survived`: index
        and impulse [N s] of the run of `wide_push` that survived the most, None without; `runs`:
        fewest of a group, the tours apart; `duration_s`: of the longest of these; and `command`,
        `confidence`, `sweeps`, `made_with`.
    """
    viable = {VIABLE: [row for row in groups[PUSHED] if row["viable"]]} if PUSHED in groups else {}
    found = {
        name: {**summarize_group(rows), **contact_figures(rows), "slowed": _slowed(rows)}
        for name, rows in {**groups, **viable}.items()
    }
    figures = {key: found.get(key, {}).get("rate") for key in (*RATES, VIABLE)}
    cases = [rows for name, rows in groups.items() if name not in (TOUR, RUN_TOUR)]
    tours, runs = (
        sorted(map(punches, groups.get(name, ())), reverse=True) for name in (TOUR, RUN_TOUR)
    )
    nominal = found.get(NOMINAL, {})
    figures |= {key: nominal.get(key) for key in (LATENCY, FALSE_RATE)}
    return {
        **figures,
        PUNCHES: tours,
        **({RUN_PUNCHES: runs} if runs else {}),
        TOUR_MEDIAN: float(np.median([survived for survived, _ in tours])) if tours else None,
        HARDEST: hardest_survived(groups.get(PUSHED, ())),
        "bars": bars(found),
        "groups": found,
        "runs": min(map(len, cases), default=0),
        "duration_s": max((r["simulated"] or 0.0 for rows in cases for r in rows), default=0.0),
        "command": command,
        "confidence": CONFIDENCE,
        "sweeps": {about["name"]: about["seed"] for about in abouts},
        "made_with": dict(abouts[0]["made_with"]) if abouts else {},
    }


def bars(groups: Mapping[str, Mapping[str, Any]]) -> dict[str, Data]:
    """Return what is asked, see `judged`: a rate by its interval; unknown where there are no runs.

    Args:
        groups: of the summary.
    """
    nominal = groups.get(NOMINAL, {})
    false = nominal.get(FALSE_RATE)
    rates = {key: groups.get(key, {"upright": 0, "n": 0}) for key in (*RATES, VIABLE)}
    return {
        **{key: rate(BARS[key], of["upright"], of["n"]) for key, of in rates.items()},
        LATENCY: judged(BARS[LATENCY], nominal.get(LATENCY)),
        FALSE_RATE: judged(BARS[FALSE_RATE], None if false is None else 100.0 * false),
    }


def punches(row: Row) -> tuple[int, int]:
    """Return how many of the pushes whose times a run samples it survived, and how many there were.

    A push is survived when another one comes before the robot falls or its legs meet.
    """
    times = sorted(t for path, t in row["sampled"].items() if path.endswith("].time"))
    ends = [end for end in (row["fall_time"], row["legs_met"]) if end is not None]
    end = min(ends, default=0.0 if row["error"] else np.inf)
    return sum(after <= end for after in [*times, np.inf][1:]), len(times)


def hardest_survived(rows: Sequence[Row]) -> dict[str, float] | None:
    """Return `index` and `impulse` [N s] of the upright run with the hardest first push."""
    hits = [(r["sampled"].get(IMPULSE, 0.0), r["index"]) for r in rows if upright(r)]
    return dict(zip(("impulse", "index"), max(hits), strict=True)) if hits else None


def contact_figures(rows: Sequence[Row]) -> dict[str, Any]:
    """Return how the contact estimator did in the runs of a group, upright or not.

    Returns:
        `latency_ms`: median over the runs of each one's median; `false_contact_rate` and
        `missed_contact_rate`: per swing [-]; `swings`: how many there were. None without any.
    """
    known = [row for row in rows if row["steps"]]
    latencies = [r["contact_latency"] for r in known if r["contact_latency"] is not None]
    swings = sum(row["steps"] for row in known)

    def rate(column: str) -> float | None:
        return sum(row[column] or 0 for row in known) / swings if swings else None

    return {
        LATENCY: float(np.median(latencies)) if latencies else None,
        FALSE_RATE: rate("false_contacts"),
        "missed_contact_rate": rate("missed_contacts"),
        "swings": swings,
    }


def _slowed(rows: Sequence[Row]) -> float | None:
    """Return in which share of the time the gait went slower than told; None without runs."""
    known = [row["slowed"] for row in rows if row["slowed"] is not None]
    return float(np.mean(known)) if known else None
