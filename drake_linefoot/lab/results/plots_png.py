"""The plots of a run as pictures, drawn by matplotlib."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from drake_linefoot.lab.results import plots
from drake_linefoot.lab.results.panels import FLIGHT, RED, SHADE, Panel, Plot
from drake_linefoot.lab.results.plots import TIME_LABEL, segment_spans
from drake_linefoot.lab.simulation.recording import Run

SIZE, DOTS_PER_INCH = (12.0, 8.0), 100  # [inch], so 1200 x 800


def write_plots(run: Run, folder: str | Path) -> list[Path]:
    """Write `plots.pictures` as PNG; return the files."""
    files = []
    for name, plot in plots.pictures(run).items():
        files.append(Path(folder) / f"{name}.png")
        draw(run, plot).savefig(files[-1], dpi=DOTS_PER_INCH)
    return files


@rc_context({"text.parse_math": False})  # a user's name may have a $ in it
def draw(run: Run, plot: Plot) -> Figure:
    """Return the figure of a plot."""
    figure = Figure(figsize=SIZE, layout="constrained")
    fell = f" (fell at {run.fall_time:.2f} s)" if run.fall_time is not None else ""
    heading = plot.heading[0].lower() + plot.heading[1:]
    figure.suptitle(f"{run.scenario.name}: {heading}{fell}", fontsize=14)
    rows = -(-len(plot.panels) // plot.columns)
    grid = figure.subplots(rows, plot.columns, sharex=True, squeeze=False)
    for ax, panel in zip(grid.flat, plot.panels, strict=False):
        _shade(ax, run)
        _draw_panel(ax, panel)
    # Slanted, for names are longer than short segments.
    style: dict[str, Any] = {"rotation": 20.0 if plot.columns == 1 else 50.0, "fontsize": 8}
    for ax in grid[0]:
        style["transform"] = ax.get_xaxis_transform()
        for name, begin, end in segment_spans(run):
            place = 0.7 * begin + 0.3 * end, 1.03
            ax.text(*place, name, rotation_mode="anchor", clip_on=False, **style)
    for ax in grid[-1]:
        ax.set_xlabel(TIME_LABEL)
    handles, labels = grid[0, 0].get_legend_handles_labels()
    entries = dict(zip(labels, handles, strict=True))
    figure.legend(entries.values(), entries, loc="outside lower center", ncols=len(entries))
    return figure


def _shade(ax: Axes, run: Run) -> None:
    """Shade the segments and mark a fall."""
    for k, (_, begin, end) in enumerate(segment_spans(run)):
        ax.axvspan(begin, end, color=str(0.97 - 0.05 * (k % 2)), lw=0, zorder=0)
    if run.fall_time is not None:
        ax.axvline(run.fall_time, color=RED, lw=3.0)
    ax.set_xlim(*plots.time_span(run))
    ax.grid(color="0.8", lw=0.5)


def _draw_panel(ax: Axes, panel: Panel) -> None:
    if panel.flights is not None and len(panel.flights):
        bars = np.column_stack([panel.flights[:, 0], np.diff(panel.flights, axis=1)])
        look: dict[str, Any] = {"color": SHADE, "lw": 0, "zorder": 0.5, "label": FLIGHT}
        whole = ax.get_xaxis_transform()
        ax.broken_barh(bars.tolist(), (0.0, 1.0), transform=whole, **look)
    for line in panel.lines:
        style: dict[str, Any] = {"ls": line.style, "lw": line.width, "solid_capstyle": "butt"}
        if line.style == "x":
            style = {"ls": "", "marker": "x"}
        ax.plot(line.time, line.values, label=line.name, color=line.colour, **style)
    ax.set_ylabel(f"{panel.label} [{panel.unit}]")
    low, high = panel.span or ax.get_ylim()
    reach = (low, high, *panel.include)
    ax.set_ylim(min(reach), max(reach))
