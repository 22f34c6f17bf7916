"""Pictures of sweeps: success rates, and where in the space of the parameters they come from."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from drake_linefoot.sweep.maps import MOST, informativeness, label, numbers, rates_by_bin
from drake_linefoot.sweep.rows import Row, upright
from studies.common.drawing import BLUE, GREY, ORANGE, RED, blank
from studies.common.types import Array
from studies.robustness.summary import THRESHOLDS

_COLUMNS = 3


def draw_rates(summary: Mapping[str, Any]) -> Figure:
    """Return the success rate of each group with its interval, and its threshold."""
    groups = {name: g for name, g in summary["groups"].items() if g["n"]}
    figure, (ax,) = blank("Runs that stay upright", 1, size=(9.0, 0.45 * len(groups) + 1.5))
    least = {one.key: one.least for one in THRESHOLDS}
    for i, (name, group) in enumerate(groups.items()):
        rate, low, high = (100.0 * group[key] for key in ("rate", "low", "high"))
        ax.barh(i, rate, color=BLUE, height=0.6)
        ax.errorbar(rate, i, xerr=[[rate - low], [high - rate]], color=ORANGE, capsize=3)
        least_of = least.get(name)
        if least_of is not None:
            ax.plot([100.0 * least_of] * 2, [i - 0.4, i + 0.4], color=RED, lw=2.0)
    ax.set_yticks(range(len(groups)), list(groups))
    ax.invert_yaxis()
    ax.set_xlim(0.0, 104.0)
    ax.set_xlabel("upright [%], with the 95 % interval; red: the threshold")
    return figure


def draw_map(name: str, rows: Sequence[Row], units: Mapping[str, str]) -> Figure | None:
    """Return where the runs of a group stay upright; None when it drew no number.

    The first axes have every run over the two parameters that tell most of success, the others
    the success rate over one parameter each, in bins of equally many runs.

    Args:
        name: of the group.
        rows: its runs.
        units: of what is drawn, by dotted path.
    """
    drawn = numbers(rows)
    if not drawn:
        return None
    good = np.array([upright(row) for row in rows])
    order = sorted(drawn, key=lambda path: -informativeness(drawn[path], good))
    lines = -(-(1 + min(len(order), MOST)) // _COLUMNS)
    figure, axes = blank(f"{name}: {good.sum()} of {len(rows)} upright", lines, _COLUMNS,
                         size=(12.0, 3.4 * lines + 0.5))  # fmt: skip
    _scatter(axes[0], drawn, good, order[:2], units)
    for ax, path in zip(axes[1:], order[:MOST], strict=False):
        _rates(ax, drawn[path], good)
        ax.set_xlabel(label(path, units))
    for ax in axes[1 + len(order[:MOST]) :]:
        ax.set_visible(False)
    return figure


def _scatter(
    ax: Axes,
    drawn: Mapping[str, Array],
    good: NDArray[np.bool_],
    paths: Sequence[str],
    units: Mapping[str, str],
) -> None:
    x = drawn[paths[0]]
    y = drawn[paths[1]] if len(paths) > 1 else np.arange(len(x), dtype=float)
    ax.plot(x[good], y[good], "o", color=BLUE, ms=3.5, label="upright")
    ax.plot(x[~good], y[~good], "x", color=RED, ms=6.0, label="not upright")
    ax.set_xlabel(label(paths[0], units))
    ax.set_ylabel(label(paths[1], units) if len(paths) > 1 else "run")
    ax.legend(fontsize=8)


def _rates(ax: Axes, values: Array, good: NDArray[np.bool_]) -> None:
    place, rate, low, high = rates_by_bin(values, good)
    bounds = 100.0 * np.array([rate - low, high - rate])
    ax.errorbar(place, 100.0 * rate, yerr=bounds, fmt="o", color=BLUE, ecolor=GREY, capsize=3)
    ax.set_ylim(0.0, 104.0)
    ax.set_ylabel("upright [%]")
