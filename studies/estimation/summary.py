"""What came of the walks, held against what is asked."""

from collections.abc import Sequence

import numpy as np
from scipy.stats import chi2

from drake_linefoot.lab.sweep.statistics import clears, interval
from studies.common.bars import Asked, compared, judged, loss
from studies.common.runs import rms
from studies.common.types import Array, Data
from studies.estimation.walks import LOSSES, SEEN, SETTLED, SPEEDS

FAST = 1.3  # [m/s] to be walked
UPRIGHT = 0.8  # [-] of the walks ahead at a speed, for it to count as walked

BARS = {
    "drift_xy_percent": Asked("off the way, at the end of the long walk", 1.0, "%", True),
    "drift_z_m": Asked("off in height, likewise", 0.03, "m", True),
    "drift_yaw_deg": Asked("off in heading, likewise", 2.0, "deg", True),
    "velocity_rmse": Asked("of the CoM's velocity", 0.03, "m/s", True),
    "tilt_rmse_deg": Asked("of roll and pitch", 0.3, "deg", True),
    "nees_inside": Asked("of the time, in which the error is as large as it is said to be", 0.9),
    **{
        f"loss_{name}": Asked("fewer upright than on the true state", 2.0, "points", True)
        for name in LOSSES
    },
    "estimator_tick_over_plant_step": Asked("time of a tick over that of the plant", 0.5, "", True),
    "forward_on_estimate": Asked("fastest of the speeds ahead that is walked", FAST, "m/s"),
}


def summarize(rows: Sequence[Data], tick_share: float) -> Data:
    """Return the numbers of `BARS`, as `bars` each with whether it is met, and what they are of.

    Args:
        rows: of `walked`.
        tick_share: of the estimator over a step of the plant [-].
    """
    groups = {name: pairs_of(rows, name) for name in LOSSES}
    ahead = [speed for size in SPEEDS if (speed := walked_ahead(rows, size))]
    values = {
        **errors_of(rows),
        "estimator_tick_over_plant_step": tick_share,
        "forward_on_estimate": max((one["size"] for one in ahead if one["met"]), default=0.0),
    }
    losses = {f"loss_{name}": (of["lost"], of["won"], of["runs"]) for name, of in groups.items()}
    bars = {
        name: loss(asked, *losses[name]) if name in losses else judged(asked, values[name])
        for name, asked in BARS.items()
    }
    fast = [one["met"] for one in ahead if one["size"] >= FAST]
    bars["forward_on_estimate"]["met"] = True in fast or (None if None in fast else False)
    found = {name: bar["value"] for name, bar in bars.items()}
    return {**found, "bars": bars, "groups": groups, "ahead": ahead}


def errors_of(rows: Sequence[Data]) -> dict[str, float]:
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


def pairs_of(rows: Sequence[Data], group: str) -> Data:
    """Return how many walks of a group stayed upright on the truth and on the estimate.

    Returns:
        `runs`: pairs of walks; `truth`, `estimate`: how many of each stayed upright; `lost`, `won`:
        pairs in which only that on the truth did, or only that on the estimate.
    """
    truth, estimate = (
        [row for row in rows if row["kind"] == group and row["on_estimate"] is on]
        for on in (False, True)
    )
    against = compared(estimate, truth)
    return {
        "runs": len(estimate),
        "truth": sum(row["upright"] for row in truth),
        "estimate": sum(row["upright"] for row in estimate),
        "lost": against["lost"],
        "won": against["won"],
    }


def walked_ahead(rows: Sequence[Data], size: float) -> Data | None:
    """Return what came of the walks ahead at a speed [m/s], None without any.

    Returns:
        `size`; `runs`; `upright`: how many stayed so; `low`: lower end of that rate [-]; whether
        it is `met`, see `clears`; `speed` that was walked, mean of those that did not fall [m/s].
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
        "met": clears(good, len(some), UPRIGHT),
        "speed": float(np.mean(known)) if known else None,
    }
