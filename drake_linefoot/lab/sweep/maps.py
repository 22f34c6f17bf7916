"""Where in the space of the sampled parameters the robot stays upright, as plots."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from plotly.graph_objects import Figure, Scatter
from plotly.subplots import make_subplots

from drake_linefoot.lab.results.judge import upright
from drake_linefoot.lab.sweep.file import SEED
from drake_linefoot.lab.sweep.rows import Row
from drake_linefoot.lab.sweep.statistics import interval, tilt
from drake_linefoot.lab.sweep.table import column
from drake_linefoot.types import Array, Flags

BINS = 5  # of equally many runs
MOST = 6  # parameters with a plot of their own, the most informative ones
TILT = "largest roll or pitch [deg]"
BLUE, RED = "#1f5fa8", "#c02020"
_SCALE = "Viridis"
_LAYOUT = {"template": "plotly_white", "margin": {"t": 20, "b": 60}}  # [pixels]


def map_figures(groups: Mapping[str, Sequence[Row]], units: Mapping[str, str]) -> dict[str, Figure]:
    """Return the plots of every group that samples a number, by their headings."""
    figures = {}
    for name, rows in groups.items():
        if sampled := numbers(rows):
            good = successes(rows)
            figures[f"{name}: every run"] = scatter_figure(rows, sampled, good, units)
            title = f"{name}: success rate by parameter, with its 95 % interval"
            figures[title] = rates_figure(sampled, good, units)
    return figures


def successes(rows: Sequence[Row]) -> Flags:
    """Return whether each run succeeded, shape (n,)."""
    return np.array([upright(row) for row in rows])


def numbers(rows: Sequence[Row]) -> dict[str, Array]:
    """Return the sampled numbers of a group, by dotted path.

    The seed is none, and what is the same in every run is not worth a plot. What tells most of
    success is first.
    """
    found = {}
    for path in dict.fromkeys(path for row in rows for path in row["sampled"]):
        values = column([row["sampled"].get(path) for row in rows])
        is_number = str(values.type) in ("double", "int64") and not values.null_count
        if path != SEED and is_number and np.ptp(values) > 0.0:
            found[path] = np.array(values, dtype=float)
    good = successes(rows)
    return dict(sorted(found.items(), key=lambda item: -informativeness(item[1], good)))


def informativeness(values: Array, good: Flags) -> float:
    """Return how much a parameter tells of success: mutual information over its bins [nat].

    Args:
        values: of the parameter, shape (n,).
        good: whether each run succeeded, shape (n,).
    """
    from scipy.stats import entropy
    from scipy.stats.contingency import crosstab, expected_freq

    counts = crosstab(bin_of(values), good).count
    return float(entropy(counts, expected_freq(counts), axis=None))


def bin_of(values: Array) -> NDArray[np.intp]:
    """Return which of the bins each value is in; equal values are in one."""
    edges = np.unique(np.quantile(values, np.linspace(0.0, 1.0, BINS + 1)[1:-1]))
    return np.searchsorted(edges, values, side="left")


def rates_by_bin(values: Array, good: Flags) -> Array:
    """Return the success rates over a parameter, in bins of equally many runs.

    Args:
        values: of the parameter, shape (n,).
        good: whether each run succeeded, shape (n,).

    Returns:
        Of each bin the mean of the parameter, the success rate, and the lower and upper bound of
        its interval, shape (4, bins).
    """
    bins = bin_of(values)
    found = []
    for inside in (bins == b for b in np.unique(bins)):
        n, k = int(inside.sum()), int(good[inside].sum())
        found.append((values[inside].mean(), k / n, *interval(k, n)))
    return np.array(found).T


def label(path: str, units: Mapping[str, str]) -> str:
    """Return a parameter with its unit."""
    return f"{path} [{units.get(path, '-')}]"


def scatter_figure(
    rows: Sequence[Row], sampled: Mapping[str, Array], good: Flags, units: Mapping[str, str]
) -> Figure:
    """Return every run over the first two parameters; its colour is the largest tilt.

    Over one alone, the tilt is the height; arguments as of `rates_figure`.
    """
    tilts = np.degrees([min(tilt(row), np.pi) for row in rows])
    axes = [*((label(path, units), values) for path, values in sampled.items()), (TILT, tilts)]
    (x_name, x), (y_name, y) = axes[:2]
    figure = Figure()
    bar = {"title": {"text": TILT, "side": "right"}}
    coloured = {"color": tilts[good].tolist(), "colorscale": _SCALE, "colorbar": bar, "size": 8}
    crossed = {"color": RED, "symbol": "x", "size": 9}
    for name, chosen, marker in (("upright", good, coloured), ("not upright", ~good, crossed)):
        figure.add_trace(
            Scatter(
                x=x[chosen].tolist(),
                y=y[chosen].tolist(),
                mode="markers",
                name=name,
                marker=marker,
                text=[hover(row) for row, one in zip(rows, chosen, strict=True) if one],
                hoverinfo="text",
            )
        )
    figure.update_xaxes(title_text=x_name)
    figure.update_yaxes(title_text=y_name)
    figure.update_layout(height=460, legend={"orientation": "h"}, **_LAYOUT)
    return figure


def hover(row: Row) -> str:
    """Return what is shown of a run under the pointer."""
    fall = f" at {row['fall_time']:.2f} s" if row["fell"] else ""
    return "<br>".join([f"run {row['index']}: {row['cause']}{fall}", *described(row["sampled"])])


def rates_figure(sampled: Mapping[str, Array], good: Flags, units: Mapping[str, str]) -> Figure:
    """Return the success rate over the first parameters, in bins of equally many runs.

    Args:
        sampled: by dotted path, each of shape (n,).
        good: whether each run succeeded, shape (n,).
        units: of the sampled values, by dotted path.
    """
    paths = list(sampled)[:MOST]
    columns = min(3, len(paths))
    lines = -(-len(paths) // columns)
    figure = make_subplots(lines, columns)
    for i, path in enumerate(paths):
        place, rate, low, high = rates_by_bin(sampled[path], good)
        bounds = {"array": 100.0 * (high - rate), "arrayminus": 100.0 * (rate - low)}
        error = {"type": "data", "symmetric": False, **bounds}
        look = {"mode": "lines+markers", "line": {"color": BLUE}}
        line = Scatter(x=place, y=100.0 * rate, error_y=error, **look)
        row, column = i // columns + 1, i % columns + 1
        figure.add_trace(line, row=row, col=column)
        figure.update_xaxes(title_text=label(path, units), row=row, col=column)
        figure.update_yaxes(title_text="upright [%]", range=[0, 104], row=row, col=column)
    figure.update_layout(height=300 * lines, showlegend=False, **_LAYOUT)
    return figure


def described(sampled: Mapping[str, Any]) -> list[str]:
    """Return sampled values in words."""
    return [f"{p} = {v:.4g}" if isinstance(v, float) else f"{p} = {v}" for p, v in sampled.items()]
