"""What came of the walks, held against what is asked."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.stats import chi2

from drake_linefoot.lab.sweep.statistics import clears, interval, loss_interval
from studies.common.runs import rms
from studies.common.types import Array, Data
from studies.estimation.walks import LOSSES, SEEN, SETTLED, SPEEDS

UPRIGHT = 0.8  # [-] of the walks ahead at a speed, for it to count as walked


class Asked(NamedTuple):
    """What is asked of a number."""

    bar: float
    unit: str
    less: bool = True  # whether less is better


BARS = {
    "drift_xy_percent": Asked(1.0, "% of the way"),
    "drift_z_m": Asked(0.03, "m"),
    "drift_yaw_deg": Asked(2.0, "deg"),
    "velocity_rmse": Asked(0.03, "m/s"),
    "tilt_rmse_deg": Asked(0.3, "deg"),
    "nees_inside": Asked(0.9, "of the time", less=False),
    **{f"loss_{name}": Asked(2.0, "points") for name in LOSSES},
    "estimator_tick_over_plant_step": Asked(0.5, "-"),
    "forward_on_estimate": Asked(1.3, "m/s", less=False),
}


def summarize(rows: Sequence[Mapping[str, Any]], tick_share: float) -> Data:
    """Return the numbers of `BARS`, as `bars` each with whether it is met, and what they are of.

    Args:
        rows: of `walked`.
        tick_share: of the estimator over a step of the plant [-].
    """
    groups = {name: loss(rows, name) for name in LOSSES}
    ahead = [speed for size in SPEEDS if (speed := walked_ahead(rows, size))]
    held = [one["size"] for one in ahead if one["holds"]]
    values = {
        **errors_of(rows),
        **{f"loss_{name}": group["loss"] for name, group in groups.items()},
        "estimator_tick_over_plant_step": tick_share,
        "forward_on_estimate": max(held, default=0.0),
    }
    bars = {name: judged(values[name], asked) for name, asked in BARS.items()}
    for name, group in groups.items():
        most, (low, high) = BARS[f"loss_{name}"].bar, group["interval"]
        met = True if high <= most else False if low > most else None
        bars[f"loss_{name}"] |= {"interval": group["interval"], "holds": met}
    fast = [one["holds"] for one in ahead if one["size"] >= BARS["forward_on_estimate"].bar]
    bars["forward_on_estimate"]["holds"] = True in fast or (None if None in fast else False)
    return {**values, "bars": bars, "groups": groups, "ahead": ahead}


def judged(value: float, asked: Asked) -> Data:
    """Return what is found and asked, and whether it `holds`, of a number without an interval."""
    holds = value <= asked.bar if asked.less else value >= asked.bar
    return {"value": value, **asked._asdict(), "holds": holds}


def errors_of(rows: Sequence[Mapping[str, Any]]) -> dict[str, float]:
    """Return drift, errors and consistency of the long walks."""
    long = [row for row in rows if row["errors"]]
    errors = [np.array(row["errors"]) for row in long]
    last = np.array([e[-1] for e in errors])
    ways = np.array([row["way"] for row in long])
    settled = np.concatenate([e[e[:, 0] > SETTLED] for e in errors])
    return {
        "drift_xy_percent": 100.0 * rms(np.linalg.norm(last[:, 7:9], axis=1) / ways),
        "drift_z_m": rms(last[:, 9]),
        "drift_yaw_deg": float(np.degrees(rms(last[:, 3]))),
        "velocity_rmse": rms(np.linalg.norm(settled[:, 19:22], axis=1)),
        "tilt_rmse_deg": float(np.degrees(rms(settled[:, 1:3]))),
        "nees_inside": nees_inside(errors),
    }


def nees_inside(errors: Sequence[Array]) -> float:
    """Return for which share of the time the mean NEES of all walks is inside its 95 % bounds."""
    length, n = min(map(len, errors)), len(errors)
    low, high = chi2.ppf([0.025, 0.975], n * len(SEEN)) / n
    mean = np.mean([e[:length, -1] for e in errors], axis=0)
    settled = errors[0][:length, 0] > SETTLED
    return float(np.mean((low < mean[settled]) & (mean[settled] < high)))


def loss(rows: Sequence[Mapping[str, Any]], group: str) -> Data:
    """Return how many walks of a group stayed upright on the truth and on the estimate.

    Returns:
        `runs`: pairs of walks; `truth`, `estimate`: how many of each stayed upright; `lost`, `won`:
        pairs in which only that on the truth did, or only that on the estimate; `loss` and its
        `interval` [points].
    """
    stays = {
        (row["index"], row["on_estimate"]): bool(row["upright"])
        for row in rows
        if row["kind"] == group
    }
    pairs = [(stays[index, False], stays[index, True]) for index, on in stays if on]
    n, lost, won = len(pairs), pairs.count((True, False)), pairs.count((False, True))
    truth, estimate = (sum(side) for side in zip(*pairs, strict=True))
    return {
        "runs": n,
        "truth": truth,
        "estimate": estimate,
        "lost": lost,
        "won": won,
        "loss": 100.0 * (lost - won) / n,
        "interval": [100.0 * end for end in loss_interval(lost, won, n)],
    }


def walked_ahead(rows: Sequence[Mapping[str, Any]], size: float) -> Data | None:
    """Return what came of the walks ahead at a speed [m/s], None without any.

    Returns:
        `size`; `runs`; `upright`: how many stayed so; `low`: lower end of that rate [-]; whether it
        `holds`, see `clears`; `speed` that was walked, mean of those that did not fall [m/s].
    """
    some = [row for row in rows if row["kind"] == "forward" and row["size"] == size]
    if not some:
        return None
    good, speeds = sum(row["upright"] for row in some), [row["speed"] for row in some]
    known = [speed for speed in speeds if speed is not None]
    return {
        "size": size,
        "runs": len(some),
        "upright": good,
        "low": interval(good, len(some))[0],
        "holds": clears(good, len(some), UPRIGHT),
        "speed": float(np.mean(known)) if known else None,
    }
