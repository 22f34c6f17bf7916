"""Parts that the pictures of the evaluation share."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from drake_linefoot.lab.results.panels import BLUE, GREEN, GREY, ORANGE, RED
from studies.common.types import Array, Data

__all__ = ["BLUE", "GREEN", "GREY", "ORANGE", "RED", "array", "blank", "fallen", "legend", "over"]


def array(values: Sequence[Any]) -> Array:
    """Return values of a JSON file as an array; None becomes NaN."""
    return np.array(values, dtype=float)


def blank(
    title: str, rows: int, columns: int = 1, size: tuple[float, float] = (11.0, 7.0), **grid: Any
) -> tuple[Figure, list[Axes]]:
    """Return an empty figure and its axes, row by row; `grid` goes to `subplots`."""
    figure = Figure(figsize=size, layout="constrained")
    figure.suptitle(title, fontsize=13)
    axes: list[Axes] = list(figure.subplots(rows, columns, squeeze=False, **grid).flat)
    for ax in axes:
        ax.grid(color="0.85", lw=0.5)
    return figure, axes


def over(
    title: str, data: Data, rows: int, columns: int = 1, span: Sequence[float] | None = None
) -> tuple[Figure, list[Axes]]:
    """Return a figure of axes over time, the segments named and a fall marked.

    `data` holds what `runs.facts` gives; `span` is begin and end of what is shown [s], else all.
    """
    size = (11.0, 2.3 * rows + 1.0)
    figure, axes = blank(title, rows, columns, size, sharex=True)
    begin, end = span or (0.0, float(data["end"]))
    for i, ax in enumerate(axes):
        ax.set_xlim(begin, max(end, begin + 1e-3))
        start = 0.0
        for name, duration in data["segments"]:
            if i < columns and max(start, begin) < end and start + duration > begin:
                at = ax.get_xaxis_transform()
                ax.text(max(start, begin), 1.02, f" {name}", transform=at, fontsize=8)
            if start > begin:
                ax.axvline(start, color="0.7", lw=1.0)
            start += duration
        if i >= len(axes) - columns:
            ax.set_xlabel("time [s]")
    if data["fell"]:
        fallen(figure, axes, data["fall_time"], data["fall_reason"])
    return figure, axes


def fallen(
    figure: Figure, axes: Sequence[Axes], time: float | None, reason: str, who: str = "the robot"
) -> None:
    """Say in the picture that a run fell, when and why."""
    first = figure.get_suptitle()
    when = "" if time is None else f" at {time:.2f} s"
    figure.suptitle(f"{first}\n{who} FELL{when}: {reason}", fontsize=13, color=RED)
    for ax in axes:
        if time is not None:
            ax.axvline(time, color=RED, lw=2.5)


def legend(figure: Figure, ax: Axes, columns: int = 4) -> Figure:
    """Return the figure with the legend of one of its axes below all of them."""
    handles, labels = ax.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=min(columns, len(labels)))
    return figure
