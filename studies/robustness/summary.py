"""What the tables of sweeps come to, held against the thresholds."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from drake_linefoot.sweep.rows import Row, upright
from drake_linefoot.sweep.statistics import CONFIDENCE, summarize_group

ENOUGH = 200  # runs of a group that the thresholds are for
LATENCY, FALSE_RATE = "latency_ms", "false_contact_rate"
NOMINAL, ROUGH, ROUGH_OFF = "nominal", "rough", "rough_no_estimator"


@dataclass(frozen=True)
class Threshold:
    """What a figure is to be."""

    key: str  # of the figure, for a success rate the name of its group
    what: str  # in words
    least: float | None = None  # lowest success rate [-], or None
    most: float | None = None  # highest value, or None


THRESHOLDS = (
    Threshold(NOMINAL, "nominal walk with random changes of the command", least=0.995),
    Threshold("push_10", "10 N s in 0.1 s, any direction and phase", least=0.98),
    Threshold("push_15", "15 N s", least=0.80),
    Threshold("push_20", "20 N s"),
    Threshold(ROUGH, "random tiles up to 3 cm above or below their mean, blind", least=0.95),
    Threshold(ROUGH_OFF, "the same with the estimator off"),
    Threshold("slope_10", "slope of 10 degrees in any direction", least=0.95),
    Threshold("model_error", "model errors, delays and noise together", least=0.90),
    Threshold(LATENCY, "detection latency over the nominal walk, median [ms]", most=8.0),
    Threshold(FALSE_RATE, "false contacts per swing over the nominal walk", most=0.01),
)
RATES = tuple(one.key for one in THRESHOLDS[:-2])


def robustness_summary(
    groups: Mapping[str, Sequence[Row]], abouts: Sequence[Mapping[str, Any]], command: str
) -> dict[str, Any]:
    """Return what `summary.json` holds.

    Args:
        groups: the rows of each.
        abouts: what is said about each table: its sweep, seed, and what it was made with.
        command: that was given.

    Returns:
        For each of `RATES` the success rate [-], None without runs; `latency_ms` and
        `false_contact_rate` of the nominal walk; `bars`: for each of them `least` or `most`, and
        whether it is `met`; `groups`: `summarize_group` and `contact_figures` of each; `paired`:
        `rough` and `rough_no_estimator` run by run; `runs`: fewest of a group; `duration_s`: of the
        longest; and `command`, `confidence`, `sweeps`, `made_with`.
    """
    found = {
        name: {**summarize_group(rows), **contact_figures(rows)} for name, rows in groups.items()
    }
    figures = {key: found.get(key, {}).get("rate") for key in RATES}
    nominal = found.get(NOMINAL, {})
    figures |= {key: nominal.get(key) for key in (LATENCY, FALSE_RATE)}
    return {
        **figures,
        "bars": {one.key: _judged(one, figures[one.key], found) for one in THRESHOLDS},
        "groups": found,
        "paired": paired(groups.get(ROUGH, ()), groups.get(ROUGH_OFF, ())),
        "runs": min((group["n"] for group in found.values()), default=0),
        "duration_s": max((r["simulated"] or 0.0 for g in groups.values() for r in g), default=0.0),
        "command": command,
        "confidence": CONFIDENCE,
        "sweeps": {about["sweep"]: about["seed"] for about in abouts},
        "made_with": dict(abouts[0]["made_with"]) if abouts else {},
    }


def contact_figures(rows: Sequence[Row]) -> dict[str, Any]:
    """Return how the contact estimator did in the runs of a group that stayed upright.

    Returns:
        `latency_ms`: median over the runs of each one's median; `false_contact_rate` and
        `missed_contact_rate`: per swing [-]; `swings`: how many there were. None without any.
    """
    known = [row for row in rows if upright(row) and row["steps"]]
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


def _judged(one: Threshold, value: float | None, groups: Mapping[str, Any]) -> dict[str, Any]:
    """Return a threshold and whether it is met; None where there is none, or nothing to judge."""
    met: bool | None = None
    if value is not None and one.least is not None:
        met = value >= one.least
    elif value is not None and one.most is not None:
        met = value <= one.most
    elif one.key == ROUGH_OFF and groups.get(ROUGH, {}).get("n") and groups[ROUGH_OFF]["n"]:
        # "Clearly less" than with the estimator: not even the intervals meet.
        met = groups[ROUGH_OFF]["high"] < groups[ROUGH]["low"]
    return {"least": one.least, "most": one.most, "met": met}


def paired(some: Sequence[Row], others: Sequence[Row]) -> dict[str, Any]:
    """Return how two groups differ in the runs of the same index and seed, as JSON can hold it.

    Such runs have the same draws, so those that end alike in both groups say nothing of the
    difference; of the others each group would have half, were there none (McNemar's exact test).

    Returns:
        `pairs`: runs that both have; `first_only`, `second_only`: of them upright in one group
        alone; `p`: two-sided, 1 when none of these is, None without pairs.
    """
    from scipy.stats import binomtest

    ours, theirs = (
        {(row["index"], row["seed"]): upright(row) for row in rows} for rows in (some, others)
    )
    pairs = [(ours[key], theirs[key]) for key in ours.keys() & theirs.keys()]
    first, second = pairs.count((True, False)), pairs.count((False, True))
    p = 1.0 if pairs else None
    if first + second:
        p = float(binomtest(first, first + second).pvalue)
    return {"pairs": len(pairs), "first_only": first, "second_only": second, "p": p}
