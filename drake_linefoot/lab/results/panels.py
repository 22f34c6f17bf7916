"""What the plots of a run over time consist of."""

from typing import Any, NamedTuple

import numpy as np

from drake_linefoot.types import Array

BLUE, ORANGE, GREEN, GREY, RED = "#1f5fa8", "#e07b00", "#2a8a4a", "#595959", "#c02020"
SHADE, FLIGHT = "#cfe3f5", "flight"  # of what is shaded, and its name
LONG, POINTS = 100_000, 20_000  # samples of a run beyond which its lines have so many points


class Line(NamedTuple):
    """A line of a panel."""

    name: str  # in the legend, where lines of one name are one entry
    time: Array  # [s], shape (n,)
    values: Array  # in the unit of the panel, shape (n,); NaN is a gap
    colour: str  # in hexadecimal digits
    width: float = 1.6  # [points]
    style: str = "-"  # or "--", or "x" for marks without a line


class Panel(NamedTuple):
    """Lines over time with a vertical axis of their own."""

    label: str  # of the axis
    unit: str  # of the axis
    lines: list[Line]  # the first one at the bottom
    span: tuple[float, float] | None = None  # of the axis; None for that of the lines
    include: tuple[float, ...] = ()  # values that an axis without a span has at least
    flights: Array | None = None  # begins and ends [s], shape (m, 2); shaded, with a span


class Plot(NamedTuple):
    """Panels that share the time."""

    heading: str
    panels: list[Panel]  # row by row
    columns: int = 1  # of panels in a picture


def thin(time: Array, values: Array, points: int) -> tuple[Array, Array]:
    """Return a line with at most `points` points that looks the same.

    The line is cut into equal stretches, and of each its lowest and its highest point stay.
    NaN stays a gap.

    Args:
        time: shape (n,).
        values: shape (n,).
        points: at most; an even number.
    """
    n, stretches = len(time), points // 2
    if n <= points:
        return time, values
    edges = np.linspace(0, n, stretches + 1).astype(int)
    begin, end = edges[:-1], edges[1:]
    # A row for each stretch; one that is shorter has its last point twice.
    at = np.minimum(begin[:, None] + np.arange((end - begin).max()), end[:, None] - 1)
    parts = values[at]
    missing = np.isnan(parts)
    low = begin + np.argmin(np.where(missing, np.inf, parts), axis=1)
    high = begin + np.argmax(np.where(missing, -np.inf, parts), axis=1)
    empty = missing.all(axis=1)
    low[empty], high[empty] = begin[empty], end[empty] - 1
    keep = np.sort(np.stack([low, high], axis=1), axis=1).ravel()
    return time[keep], values[keep]


def line(name: str, time: Array, values: Array, colour: str, *look: Any, **more: Any) -> Line:
    """Return a line; one of a long run as few of its points."""
    if len(time) > LONG:
        time, values = thin(time, values, POINTS)
    return Line(name, time, values, colour, *look, **more)
