"""The report of a run: one page that opens from disk and needs no network.

Its plots can be zoomed and hovered over; they are drawn by plotly.
"""

import math
from typing import Any

import numpy as np
from plotly.graph_objects import Figure
from plotly.subplots import make_subplots

from drake_linefoot.errors import InputError
from drake_linefoot.lab.results import plots
from drake_linefoot.lab.results.contact_events import intervals, standing
from drake_linefoot.lab.results.metrics import compute_metrics
from drake_linefoot.lab.results.page import render
from drake_linefoot.lab.results.panels import FLIGHT, GREEN, RED, SHADE, Line, Panel, Plot, thin
from drake_linefoot.lab.results.plots import FEET, SIDES, TIME_LABEL
from drake_linefoot.lab.results.poses import draw_walk, png
from drake_linefoot.lab.results.pressure import pressure_plot
from drake_linefoot.lab.results.tables import (
    GAIT,
    GAIT_HEAD,
    NOTHING,
    SEGMENTS,
    gait_rows,
    number,
    segment_rows,
    summary_rows,
)
from drake_linefoot.lab.results.thresholds import thresholds_of
from drake_linefoot.lab.scenario.load import dump_scenario
from drake_linefoot.lab.simulation.foot_points import OUTLINES
from drake_linefoot.lab.simulation.recording import CHANNELS, Run
from drake_linefoot.page import Page

POINTS = 4000  # of a line at most; a longer one keeps the extremes of equal stretches
SHADES = ("#f6f7f8", "#eceef1")  # of the segments, in turn
DEGREES = {"rad": ("deg", np.degrees(1.0))}  # units that a reader knows better, and their size
LEAST_ERROR = 1e-3  # [m/s], [rad/s] that is said
DASHES = {"-": "solid", "--": "dash"}


def report_html(run: Run, metrics: dict[str, Any], links: dict[str, str]) -> str:
    """Return the report of a run as a page: verdict, picture, figures, plots, scenario.

    The `metrics` are those of `compute_metrics`; `links` lead by their words to files beside it.

    Raises:
        InputError: the run has no sample.
    """
    if not len(run.time):
        raise InputError("run", "time", "of 0 samples", "must have one at least")
    return render(
        "report.html.j2",
        title=f"{run.scenario.name}, report of drake_linefoot",
        run=run,
        links=links,
        verdict=verdict(metrics),
        picture=png(draw_walk(run)),
        segments_title=SEGMENTS,
        segments=velocity_rows(metrics),
        gait_title=GAIT,
        gait_head=("", *GAIT_HEAD[1:]),
        gait=gait_rows(metrics),
        summary=[(name, *values) for name, values in summary_rows(metrics).items()],
        figures=report_figures(run),
        scenario=dump_scenario(run.scenario),
    )


def show_report(run: Run, height: int) -> Page:
    """Return the report of a run as a page, see `Run.report`."""
    html = report_html(run, compute_metrics(run), {})
    return Page("report.html", html, height).presented()


def verdict(metrics: dict[str, Any]) -> str:
    """Return what came of a run in a few short sentences."""
    m = metrics
    end = number(m["duration_s"], ".1f")
    said = [f"Fell after {end} s" if m["fell"] else f"Stayed up for {end} s"]
    errors = [segment["error"] for segment in m["segments"] if segment["error"] is not None]
    if errors:
        along = max(LEAST_ERROR, *(math.hypot(*error[:2]) for error in errors))
        turning = max(LEAST_ERROR, *(abs(error[2]) for error in errors))
        said.append(f"followed its commands within {along:.2g} m/s and {turning:.2g} rad/s")
    share = sum(part["share"] for part in m["slowed"])
    said.append(f"slowed: {share:.0%} of the time" if m["slowed"] else "slowed: never")
    if failed := [name for name, count in m["solver_failures"].items() if count]:
        said.append(f"not always solved: {', '.join(failed).upper()}")
    return "; ".join(said) + "."


def velocity_rows(metrics: dict[str, Any]) -> list[list[str]]:
    """Return the rows of `segment_rows`, with a number in each cell and without the error."""
    rows = []
    for name, *columns, _ in segment_rows(metrics):
        cells = [[NOTHING] * 3 if text == NOTHING else text.split() for text in columns]
        rows.append([name, *cells[0], *cells[1]])
    return rows


def report_figures(run: Run) -> dict[str, Figure]:
    """Return the plots of a run by their headings."""
    velocity = plots.velocity(run, "centre of mass", run.com)
    over_time = [velocity, plots.orientation(run), plots.forces(run), pressure_plot(run)]
    over_time.append(plots.torque_shares(run))
    if run.scenario.estimation and len(run.time):
        over_time.append(plots.estimation(run))
    figures = {plot.heading: draw(run, plot) for plot in over_time}
    figures["Footsteps from above"] = footstep_figure(run)
    solvers = plots.solvers(run)
    return {**figures, solvers.heading: draw(run, solvers)}


def draw(run: Run, plot: Plot) -> Figure:
    """Return the figure of a plot, its panels one below the other."""
    rows = len(plot.panels)
    figure = make_subplots(rows=rows, cols=1, shared_xaxes=True, vertical_spacing=0.14 / rows)
    _style(figure, 110 + 190 * rows if rows > 2 else 110 + 250 * rows)
    figure.update_layout(hovermode="x unified")
    _shade(figure, run, rows)
    for row, panel in enumerate(plot.panels, start=1):
        unit, size = DEGREES.get(panel.unit, (panel.unit, 1.0))
        _draw_flights(figure, row, panel)
        for line in panel.lines:
            _draw_line(figure, row, line, size)
        axis: dict[str, Any] = {"title_text": f"{panel.label} [{unit}]", "hoverformat": ".4g"}
        if panel.span is not None:
            axis["range"] = [size * value for value in panel.span]
        axis["autorangeoptions_include"] = [size * value for value in panel.include]
        figure.update_yaxes(**axis, row=row, col=1)
    span = list(plots.time_span(run))
    figure.update_xaxes(range=span, unifiedhovertitle_text="t = %{x:.3f} s")
    figure.update_xaxes(title_text=TIME_LABEL, row=rows, col=1)
    return figure


def footstep_figure(run: Run) -> Figure:
    """Contact lines of every stance, and the path of the centre of mass."""
    figure = Figure()
    _style(figure, 620)
    figure.update_layout(margin_t=20)
    keep = slice(None, None, -(-len(run.time) // POINTS))
    hover = "x %{x:.3f} m<br>y %{y:.3f} m<br>t %{customdata:.2f} s<extra></extra>"
    figure.add_scatter(
        x=run.com[keep, 0].astype(np.float32),
        y=run.com[keep, 1].astype(np.float32),
        customdata=run.time[keep],
        name="centre of mass",
        mode="lines",
        line={"color": GREEN, "width": 1.5},
        hovertemplate=hover,
    )
    touched = run.contact_points
    for side, colour in enumerate(SIDES.values()):
        stands = standing(run.time, run.true_force[:, side, 2], thresholds_of(run))
        line: list[list[float]] = []
        for begin, end in intervals(stands):
            middle = (begin + end) // 2  # the foot lies flat
            points, at = touched[middle, side, :, :2], float(run.time[begin])
            line += [[*points[k], at] for k in OUTLINES[len(points)]]
            line.append([np.nan, np.nan, at])
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
    unit = CHANNELS["com"].unit
    figure.update_xaxes(title_text=f"x [{unit}]")
    figure.update_yaxes(title_text=f"y [{unit}]", scaleanchor="x", scaleratio=1.0)
    return figure


def _draw_flights(figure: Figure, row: int, panel: Panel) -> None:
    """Shade the flights of a panel, as one entry of the legend for all of them."""
    if panel.flights is None or panel.span is None or not len(panel.flights):
        return
    corners = [0, 0, 1, 1, 0]  # of each, begin or end, low or high
    x = np.insert(panel.flights[:, corners], 5, np.nan, axis=1)
    y = np.tile([*np.array(panel.span)[[0, 1, 1, 0, 0]], np.nan], len(x))
    figure.add_scatter(
        x=x.ravel(),
        y=y,
        name=FLIGHT,
        legendgroup=FLIGHT,
        showlegend=row == 1,
        mode="none",
        fill="toself",
        fillcolor=SHADE,
        hoverinfo="skip",
        row=row,
        col=1,
    )


def _draw_line(figure: Figure, row: int, line: Line, size: float) -> None:
    """Draw a line in a row; the same name in several rows is one entry of the legend."""
    x, y = thin(line.time, size * line.values, POINTS)
    look: dict[str, Any] = {
        "mode": "lines",
        "line": {"color": line.colour, "width": line.width, "dash": DASHES.get(line.style)},
    }
    if line.style == "x":
        look = {"mode": "markers", "marker": {"symbol": "x", "color": line.colour, "size": 9}}
    figure.add_scatter(
        x=x.astype(np.float32),
        y=y.astype(np.float32),
        name=line.name,
        legendgroup=line.name,
        showlegend=not any(trace.name == line.name for trace in figure.data),
        row=row,
        col=1,
        **look,
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


def _shade(figure: Figure, run: Run, rows: int) -> None:
    """Shade and name the segments, and mark a fall, in every panel.

    All at once: each `add_vrect` of plotly copies those that are there.
    """
    spans = list(plots.segment_spans(run))
    marks: list[dict[str, Any]] = [
        {"type": "rect", "x0": begin, "x1": end, "fillcolor": SHADES[k % 2], "layer": "below"}
        | {"line": {"width": 0}}
        for k, (_, begin, end) in enumerate(spans)
    ]
    if run.fall_time is not None:
        fall = {"type": "line", "x0": run.fall_time, "x1": run.fall_time}
        marks.append({**fall, "line": {"color": RED, "width": 3}})
    axes = ["", *map(str, range(2, rows + 1))]
    places = [{"xref": f"x{i}", "yref": f"y{i} domain", "y0": 0, "y1": 1} for i in axes]
    look = {"xanchor": "left", "yanchor": "bottom", "textangle": -20, "showarrow": False}
    place = {"y": 1.0, "xref": "x", "yref": "paper"}
    figure.update_layout(
        shapes=[{**mark, **where} for mark in marks for where in places],
        annotations=[{"text": name, "x": begin, **place, **look} for name, begin, _ in spans],
    )
