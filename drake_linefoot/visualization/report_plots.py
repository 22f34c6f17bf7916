"""Plots of a run that can be zoomed and hovered over, for its report."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.simulation.contact_events import intervals, standing
from drake_linefoot.simulation.recording import Run
from drake_linefoot.visualization.plots import FEET, SMOOTHING, smoothed_velocity

if TYPE_CHECKING:
    from plotly.graph_objects import Figure

Array = NDArray[np.float64]

POINTS = 4000  # of a line at most; a longer one keeps the extremes of equal stretches
LEFT, RIGHT = "#c02020", "#1f5fa8"  # as in the pictures of `plots`
ORANGE, GREEN, GREY, RED = "#e07b00", "#2a8a4a", "#666666", "#c02020"
SHADES = ("#f6f7f8", "#eceef1")  # of the segments, in turn
JOINT_COLOURS = (
    *("#1f5fa8", "#e07b00", "#2a8a4a", "#c02020", "#7b4fa3"),
    *("#8c564b", "#d65fa8", "#6b6b6b", "#a3a01f", "#17a0b0"),
)


def report_figures(run: Run) -> dict[str, Figure]:
    """Return the plots of a run by their headings."""
    made: dict[str, Callable[[Run], Figure]] = {
        "Velocity of the centre of mass, in the heading frame": velocity_figure,
        "Orientation of the torso": orientation_figure,
        "Normal force of each foot": force_figure,
        "Joint torques as a share of their limits": torque_figure,
        "Footsteps from above": footstep_figure,
        "Solver times and failures": solver_figure,
    }
    return {heading: make(run) for heading, make in made.items()}


def velocity_figure(run: Run) -> Figure:
    """Commanded and measured velocity of the centre of mass."""
    figure = _over_time(run, ("forward [m/s]", "left [m/s]", "turn rate [rad/s]"))
    time, measured = smoothed_velocity(run, run.com)
    for i in range(3):
        _line(figure, i, run.time, run.command[:, i], "commanded", GREY, dash="dash")
        _line(figure, i, run.time, run.reference_command[:, i], "after limits", ORANGE)
        _line(figure, i, time, measured[:, i], f"measured, mean over {SMOOTHING} s", RIGHT)
    return figure


def orientation_figure(run: Run) -> Figure:
    """Roll, pitch and yaw of the torso with their references."""
    figure = _over_time(run, ("roll [deg]", "pitch [deg]", "yaw [deg]"))
    level = np.zeros(len(run.time))
    references = (level, level, np.unwrap(run.reference_yaw))
    for i, reference in enumerate(references):
        _line(figure, i, run.time, np.degrees(reference), "reference", GREY, dash="dash")
        _line(figure, i, run.time, np.degrees(run.rpy[:, i]), "measured", RIGHT)
    return figure


def force_figure(run: Run) -> Figure:
    """Normal force of each foot: true, estimated, planned."""
    figure = _over_time(run, tuple(f"{foot} [N]" for foot in FEET))
    for side in range(2):
        _line(figure, side, run.time, run.true_force[:, side, 2], "true", GREEN, width=2.5)
        estimated, planned = run.contact_wrench[:, side, 2], run.mpc_wrench[:, side, 2]
        _line(figure, side, run.time, estimated, "estimated", RIGHT, width=1.0)
        _line(figure, side, run.time, planned, "planned by the MPC", ORANGE, width=1.5)
        top = max(float(np.nanmax(run.true_force[:, side, 2])), 10.0)
        figure.update_yaxes(range=[-0.1 * top, 1.15 * top], row=side + 1, col=1)
    return figure


def torque_figure(run: Run) -> Figure:
    """Torque of every joint over its limit, left and right in two panels."""
    figure = _over_time(run, ("left [% of limit]", "right [% of limit]"))
    colours: dict[str, str] = {}
    for joint, name in enumerate(run.joint_names):
        side = int(name.startswith("right"))
        plain = name.removeprefix("left_").removeprefix("right_").replace("_", " ")
        colour = colours.setdefault(plain, JOINT_COLOURS[len(colours) % len(JOINT_COLOURS)])
        share = 100.0 * run.torque[:, joint] / run.effort_limits[joint]
        _line(figure, side, run.time, share, plain, colour, width=1.0)
    for row in (1, 2):
        for limit in (-100.0, 100.0):
            figure.add_hline(limit, line={"color": GREY, "dash": "dash", "width": 1}, row=row)
        figure.update_yaxes(range=[-110.0, 110.0], row=row, col=1)
    return figure


def solver_figure(run: Run) -> Figure:
    """Wall time of both programs; a cross where one was not solved."""
    figure = _over_time(run, ("MPC [ms]", "whole-body controller [ms]"))
    failed = np.diff(run.mpc_failures, prepend=0.0) > 0.0, run.wbc_success == 0.0
    for row, milliseconds in enumerate((run.mpc_ms, run.wbc_ms)):
        known = ~np.isnan(milliseconds)
        _line(figure, row, run.time[known], milliseconds[known], "wall time", RIGHT, width=1.0)
        at = np.flatnonzero(failed[row])
        figure.add_scatter(
            x=run.time[at],
            y=np.nan_to_num(milliseconds[at]),
            name=f"not solved ({len(at)})",
            mode="markers",
            marker={"symbol": "x", "color": RED, "size": 9},
            row=row + 1,
            col=1,
        )
        figure.update_yaxes(rangemode="tozero", row=row + 1, col=1)
    return figure


def footstep_figure(run: Run) -> Figure:
    """Contact lines of every stance, and the path of the centre of mass."""
    from plotly.graph_objects import Figure

    figure = Figure()
    _style(figure, 620)
    figure.update_layout(margin_t=20)
    x, y, time = _thinned_path(run.time, run.com[:, :2])
    style = {"mode": "lines", "line": {"color": GREEN, "width": 1.5}}
    hover = "x %{x:.3f} m<br>y %{y:.3f} m<br>t %{customdata:.2f} s<extra></extra>"
    figure.add_scatter(
        x=x, y=y, customdata=time, name="centre of mass", hovertemplate=hover, **style
    )
    for side, colour in enumerate((LEFT, RIGHT)):
        stands = standing(run.time, run.true_force[:, side, 2])
        line: list[list[float]] = []
        for begin, end in intervals(stands):
            middle = (begin + end) // 2  # the foot lies flat
            heel, toe = run.contact_points[middle, side, :, :2]
            at = float(run.time[begin])
            line += [[*heel, at], [*toe, at], [np.nan, np.nan, at]]
        points = np.array(line).reshape(-1, 3)
        figure.add_scatter(
            x=points[:, 0],
            y=points[:, 1],
            customdata=points[:, 2],
            name=FEET[side],
            mode="lines+markers",
            line={"color": colour, "width": 5},
            marker={"size": 5},
            hovertemplate=hover.replace("t %", "stands from %"),
        )
    figure.update_xaxes(title_text="x [m]")
    figure.update_yaxes(title_text="y [m]", scaleanchor="x", scaleratio=1.0)
    return figure


def thin(time: Array, values: Array, points: int = POINTS) -> tuple[Array, Array]:
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
    keep = []
    for begin, end in pairwise(edges):
        part = values[begin:end]
        if np.isnan(part).all():
            keep += [begin, end - 1]
        else:
            keep += sorted((begin + int(np.nanargmin(part)), begin + int(np.nanargmax(part))))
    return time[keep], values[keep]


def _thinned_path(time: Array, path: Array) -> tuple[Array, Array, Array]:
    """Return x, y and time of a path of at most `POINTS` points."""
    keep = slice(None, None, -(-len(time) // POINTS))
    return path[keep, 0].astype(np.float32), path[keep, 1].astype(np.float32), time[keep]


def _line(
    figure: Figure,
    row: int,
    time: Array,
    values: Array,
    name: str,
    colour: str,
    *,
    width: float = 1.6,
    dash: str = "solid",
) -> None:
    """Draw a line in a row, counted from 0; the same name in several rows is one entry."""
    x, y = thin(time, values)
    figure.add_scatter(
        x=x.astype(np.float32),
        y=y.astype(np.float32),
        name=name,
        legendgroup=name,
        showlegend=not any(trace.name == name for trace in figure.data),
        mode="lines",
        line={"color": colour, "width": width, "dash": dash},
        row=row + 1,
        col=1,
    )


def _style(figure: Figure, height: int) -> None:
    """Give a figure its size, its fonts and its legend."""
    figure.update_layout(
        height=height,
        margin={"l": 80, "r": 20, "t": 60, "b": 50},
        template="simple_white",
        font={"size": 13},
        legend={"orientation": "h", "yanchor": "top", "y": -0.1 * 620 / height, "x": 0.0},
        hovermode="closest",
        hoverlabel={"namelength": -1},
    )
    grid: dict[str, Any] = {"showgrid": True, "gridcolor": "#dddddd", "zeroline": False}
    figure.update_xaxes(**grid)
    figure.update_yaxes(**grid)


def _over_time(run: Run, labels: tuple[str, ...]) -> Figure:
    """Return a figure with one panel per label over time, segments shaded and a fall marked."""
    from plotly.subplots import make_subplots

    rows = len(labels)
    figure = make_subplots(rows=rows, cols=1, shared_xaxes=True, vertical_spacing=0.14 / rows)
    _style(figure, 110 + 190 * rows if rows > 2 else 110 + 250 * rows)
    figure.update_layout(hovermode="x unified")
    end = max(float(run.time[-1]), 1e-3)
    ends = np.concatenate([[0.0], np.cumsum([s.duration for s in run.scenario.segments])])
    for k, (begin, stop) in enumerate(pairwise(ends)):
        if begin >= end:
            break
        shade: dict[str, Any] = {"fillcolor": SHADES[k % 2], "line_width": 0, "opacity": 1.0}
        figure.add_vrect(
            begin, min(stop, end), exclude_empty_subplots=False, layer="below", **shade
        )
        name = run.scenario.segments[k].name
        place = {"x": begin, "y": 1.0, "xref": "x", "yref": "paper"}
        figure.add_annotation(
            text=name, xanchor="left", yanchor="bottom", textangle=-20, showarrow=False, **place
        )
    if run.fall_time is not None:
        mark = {"color": RED, "width": 3}
        figure.add_vline(run.fall_time, line=mark, exclude_empty_subplots=False)
    for row, label in enumerate(labels, start=1):
        figure.update_yaxes(title_text=label, hoverformat=".4g", row=row, col=1)
    figure.update_xaxes(
        range=[0.0, end * (1.01 if run.fell else 1.0)], unifiedhovertitle_text="t = %{x:.3f} s"
    )
    figure.update_xaxes(title_text="time [s]", row=rows, col=1)
    return figure
