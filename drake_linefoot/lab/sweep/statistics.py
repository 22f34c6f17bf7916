"""Success rates with their intervals, causes and spreads of the runs of a sweep."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from statistics import NormalDist
from typing import Any

import numpy as np

from drake_linefoot.lab.results.judge import upright
from drake_linefoot.lab.sweep.rows import Row

CONFIDENCE = 0.95  # [-] of the intervals
_NORMAL = NormalDist().inv_cdf(0.5 + 0.5 * CONFIDENCE)
SPREAD = {"roll_max": "rad", "pitch_max": "rad", "speed_error": "m/s", "contact_latency": "ms"}


def interval(successes: int, runs: int) -> tuple[float, float]:
    """Return Wilson's interval of a success rate over at least one run, at `CONFIDENCE`."""
    from scipy.stats import binomtest

    found = binomtest(successes, runs).proportion_ci(CONFIDENCE, method="wilson")
    return float(found.low), float(found.high)


def clears(successes: int, runs: int, bar: float) -> bool | None:
    """Return whether a success rate is a bar's: by the lower end of its `interval`.

    Args:
        successes: of so many runs.
        runs: at least one.
        bar: the least rate [-].

    Returns:
        False where the upper end is below the bar; None in between: so few runs cannot tell.
    """
    low, high = interval(successes, runs)
    if low >= bar:
        return True
    return False if high < bar else None


def loss_interval(lost: int, won: int, pairs: int) -> tuple[float, float]:
    """Return the interval of how much smaller one success rate is than another, of pairs of runs.

    Bonett and Price (2012), at `CONFIDENCE`: Wald's, with one more pair lost and one more won.

    Args:
        lost: pairs in which only the run of the other succeeded.
        won: pairs in which only that of the one did.
        pairs: all of them, at least one.

    Returns:
        Its ends [-], below zero where the one has the larger rate.
    """
    p, q = ((count + 1.0) / (pairs + 2.0) for count in (lost, won))
    half = _NORMAL * math.sqrt((p + q - (p - q) ** 2) / (pairs + 2.0))
    return p - q - half, p - q + half


def summarize_group(rows: Sequence[Row]) -> dict[str, Any]:
    """Return the statistics of the runs of a group, as JSON can hold them.

    Returns:
        `n`: runs that are done; `upright`; `rate`, `low`, `high`: success rate and its interval
        (None without runs); `fell`; `errors`: runs without an outcome, which count as not
        upright; `redone`: runs done again because a worker died; `causes`: how many of each, the
        leading one first; `fall_time`: median [s]; and median, 95th percentile and maximum of
        each of `SPREAD`.
    """
    n, good = len(rows), sum(map(upright, rows))
    low, high = interval(good, n) if n else (None, None)
    causes = Counter(row["cause"] for row in rows if not upright(row))
    falls = [row["fall_time"] for row in rows if row["fell"]]
    return {
        "n": n,
        "upright": good,
        "rate": good / n if n else None,
        "low": low,
        "high": high,
        "fell": sum(row["fell"] is True for row in rows),
        "errors": sum(bool(row["error"]) for row in rows),
        "redone": sum(row["attempts"] > 1 for row in rows),
        "causes": dict(causes.most_common()),
        "fall_time": float(np.median(falls)) if falls else None,
        **{name: _spread([row[name] for row in rows]) for name in SPREAD},
    }


def compare_groups(rows: Sequence[Row], others: Sequence[Row]) -> dict[str, Any]:
    """Return in how many runs one group did better than another, run by run.

    Only runs with one index are compared, for they have the same samples.

    Returns:
        `won`, `lost`: runs that were upright in one group only, this one or the other; `p`: how
        likely chance gives so uneven a count or a more uneven one (exact, McNemar).
    """
    from scipy.stats import binomtest

    theirs = {row["index"]: upright(row) for row in others}
    pairs = [(upright(row), theirs[row["index"]]) for row in rows if row["index"] in theirs]
    won, lost = pairs.count((True, False)), pairs.count((False, True))
    p = float(binomtest(won, won + lost).pvalue) if won + lost else 1.0
    return {"won": won, "lost": lost, "p": p}


def summarize_groups(groups: Mapping[str, Sequence[Row]]) -> dict[str, dict[str, Any]]:
    """Return `summarize_group` of each; of all but the first `against`, `compare_groups` to it."""
    found = {name: summarize_group(rows) for name, rows in groups.items()}
    first, *others = groups
    for name in others:
        found[name]["against"] = {"group": first, **compare_groups(groups[name], groups[first])}
    return found


def worst(rows: Sequence[Row], n: int) -> list[Row]:
    """Return the `n` worst runs that have an outcome: falls, the earliest first, then tilt."""

    def badness(row: Row) -> tuple[float, float]:
        early = -row["fall_time"] if row["fell"] else -np.inf
        return early, tilt(row)

    known = [row for row in rows if not row["error"]]
    return sorted(known, key=badness, reverse=True)[:n]


def tilt(row: Row) -> float:
    """Return the largest roll or pitch of a run [rad]; infinite when it is not known."""
    values = (row["roll_max"], row["pitch_max"])
    return max(np.inf if value is None else float(value) for value in values)


def _spread(values: Sequence[float | None]) -> dict[str, float] | None:
    known = [value for value in values if value is not None]
    if not known:
        return None
    return {
        "median": float(np.median(known)),
        "p95": float(np.percentile(known, 95)),
        "max": float(max(known)),
    }
