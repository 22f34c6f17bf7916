"""What came of the trials: survival, tilt and speed of each variant, beside the base's."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from drake_linefoot.lab.sweep.statistics import interval
from studies.common.bars import compared
from studies.common.drawing import BLUE, GREY, array, blank
from studies.common.types import Data
from studies.models.cases import (
    BASE,
    FACTORS,
    GENTLE,
    HARD,
    HORIZON,
    HORIZONS,
    MODELS,
    VARIANTS,
    level,
)

KNOTS = 14  # of `BASE`
MEASURED = ("roll", "pitch", "speed_error")


def summed(rows: Sequence[Data]) -> dict[str, Data]:
    """Return the figures of each variant that was tried.

    Returns:
        `what`; `runs`, `upright`, `low`, `high`: Wilson's interval; `roll`, `pitch` [rad],
        `speed_error` [m/s]: medians of its runs that stayed upright, None without; of models and
        horizons `against`: `compared` with the base, run by run, and `pitch_ratio`: median
        over the draws in which both stayed upright, None without.
    """
    by = {name: [row for row in rows if row["variant"] == name] for name in VARIANTS}
    found: dict[str, Data] = {}
    for name, of in by.items():
        if not of:
            continue
        good = [row for row in of if row["upright"]]
        low, high = interval(len(good), len(of))
        found[name] = {
            "what": VARIANTS[name].what,
            "runs": len(of),
            "upright": len(good),
            "low": low,
            "high": high,
            **{key: _median([row[key] for row in good]) for key in MEASURED},
        }
        if name != BASE and name in MODELS | HORIZONS and by[BASE]:
            base = {row["index"]: row for row in by[BASE] if row["upright"]}
            pairs = [(row, base[row["index"]]) for row in good if row["index"] in base]
            ratios = [one["pitch"] / other["pitch"] for one, other in pairs]
            found[name] |= {
                "against": compared(of, by[BASE]),
                "pitch_ratio": _median(ratios),
            }
    return found


def _median(values: Sequence[float]) -> float | None:
    return float(np.median(values)) if values else None


def draw(found: dict[str, Data]) -> Figure:
    """Return survival over the horizon and over each factor, with Wilson's intervals."""
    figure, axes = blank("Share that stays upright", 2, 2, (10.0, 7.0))
    knots = {int(name.removeprefix(f"{HORIZON}_")): name for name in HORIZONS} | {KNOTS: BASE}
    panels: list[tuple[str, dict[float, str]]] = [
        (f"intervals of the horizon, pushed with {HARD} N s", dict(sorted(knots.items())))
    ]
    for name, one in FACTORS.items():
        panels.append((f"{one.label}; {GENTLE} N s", {x: level(name, x) for x in one.levels}))
    for ax, (label, names) in zip(axes, panels, strict=True):
        _panel(ax, label, {x: found[name] for x, name in names.items() if name in found})
    return figure


def _panel(ax: Axes, label: str, of: dict[float, Data]) -> None:
    x = array(list(of))
    low, high, rate = (
        100.0 * array(values)
        for values in (
            [one["low"] for one in of.values()],
            [one["high"] for one in of.values()],
            [one["upright"] / one["runs"] for one in of.values()],
        )
    )
    ax.fill_between(x, low, high, color=GREY, alpha=0.3, lw=0.0)
    ax.plot(x, rate, "o-", color=BLUE)
    ax.set_ylim(-3.0, 103.0)
    ax.set_xlabel(label)
    ax.set_ylabel("upright [%]")
