"""Pictures of a run over time, as PNG files."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.simulation.contact_events import Flags, intervals, standing
from drake_linefoot.simulation.heading import mean_velocity
from drake_linefoot.simulation.recording import Run

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

SIZE, DOTS_PER_INCH = (12.0, 8.0), 100  # [inch], so 1200 x 800
SMOOTHING = 0.4  # [s] window of the measured velocity, about one stride
FEET = ("left foot", "right foot")
BLUE, ORANGE, GREEN, GREY, RED = "#1f5fa8", "#e07b00", "#2a8a4a", "0.35", "#c02020"


def write_plots(run: Run, folder: str | Path) -> list[Path]:
    """Write `velocity`, `orientation`, `wrenches`, `torques` and `contact` as PNG files.

    Args:
        run: what was recorded.
        folder: an existing folder.

    Returns:
        The files.
    """
    plots: dict[str, Callable[[Run], Figure]] = {
        "velocity": plot_velocity,
        "orientation": plot_orientation,
        "wrenches": plot_wrenches,
        "torques": plot_torques,
        "contact": plot_contact,
    }
    files = []
    for name, plot in plots.items():
        files.append(Path(folder) / f"{name}.png")
        plot(run).savefig(files[-1], dpi=DOTS_PER_INCH)
    return files


def plot_velocity(run: Run) -> Figure:
    """Plot commanded and measured velocity in the heading frame."""
    figure, axes = _figure(run, "Velocity of the torso in the heading frame", 3)
    time, measured = smoothed_velocity(run, run.q[:, 4:6])
    names = ("forward [m/s]", "left [m/s]", "turn rate [rad/s]")
    for i, (ax, name) in enumerate(zip(axes, names, strict=True)):
        ax.plot(run.time, run.command[:, i], color=GREY, ls="--", label="commanded")
        ax.plot(run.time, run.reference_command[:, i], color=ORANGE, label="after limits")
        label = f"measured, mean over {SMOOTHING} s"
        ax.plot(time, measured[:, i], color=BLUE, label=label)
        ax.set_ylabel(name)
        _at_least(ax, 0.1)
    return _with_legend(figure, axes[0])


def plot_orientation(run: Run) -> Figure:
    """Plot roll, pitch and yaw of the torso with their references."""
    figure, axes = _figure(run, "Orientation of the torso", 3)
    level = np.zeros(len(run.time))
    references = (level, level, np.unwrap(run.reference_yaw))
    for i, (ax, name) in enumerate(zip(axes, ("roll", "pitch", "yaw"), strict=True)):
        ax.plot(run.time, references[i], color=GREY, ls="--", label="reference")
        ax.plot(run.time, run.rpy[:, i], color=BLUE, label="measured")
        ax.set_ylabel(f"{name} [rad]")
        _at_least(ax, 0.02)
    return _with_legend(figure, axes[0])


def plot_wrenches(run: Run) -> Figure:
    """Plot the normal force of each foot: planned, counted on, and true."""
    figure, axes = _figure(run, "Normal force of each foot", 2)
    for side, ax in enumerate(axes):
        true = run.true_force[:, side, 2]
        mpc, wbc = run.mpc_wrench[:, side, 2], run.wbc_wrench[:, side, 2]
        ax.plot(run.time, mpc, color=ORANGE, lw=4.0, alpha=0.5, label="MPC")
        ax.plot(run.time, true, color=GREEN, lw=1.8, label="true")
        ax.plot(run.time, wbc, color=BLUE, lw=0.7, label="whole-body controller")
        ax.set_ylabel(f"{FEET[side]} [N]")
        top = max(np.nanmax(true), 10.0)
        ax.set_ylim(-0.05 * top, 1.15 * top)
    return _with_legend(figure, axes[0])


def plot_torques(run: Run) -> Figure:
    """Plot the torque of every joint with its limits, left and right in one panel."""
    joints: dict[str, list[int]] = {}
    for i, name in enumerate(run.joint_names):
        joints.setdefault(name.removeprefix("left_").removeprefix("right_"), []).append(i)
    columns = 3
    figure, axes = _figure(run, "Joint torques", -(-len(joints) // columns), columns)
    for ax, (name, pair) in zip(axes, joints.items(), strict=False):
        for joint in pair:
            right = run.joint_names[joint].startswith("right_")
            colour, label = (BLUE, "right") if right else (RED, "left")
            ax.plot(run.time, run.torque[:, joint], color=colour, lw=0.7, label=label)
        limit = run.effort_limits[pair[0]]
        ax.axhline(limit, color=GREY, ls="--", lw=1.0, label="limit")
        ax.axhline(-limit, color=GREY, ls="--", lw=1.0)
        ax.set_ylim(-1.15 * limit, 1.15 * limit)
        ax.set_ylabel(f"{name.replace('_', ' ')} [N m]")
    return _with_legend(figure, axes[0])


def plot_contact(run: Run) -> Figure:
    """Plot the estimated normal force and the contact flag against the truth."""
    figure, axes = _figure(run, "Contact estimate against the truth", 2)
    for side, ax in enumerate(axes):
        true = run.true_force[:, side, 2]
        ax.plot(run.time, true, color=GREEN, lw=2.5, alpha=0.6, label="true normal force")
        estimate = run.contact_wrench[:, side, 2]
        ax.plot(run.time, estimate, color=BLUE, lw=0.8, label="estimated normal force")
        top = max(np.nanmax(true), 10.0)
        _bar(ax, run, standing(run.time, true), -0.08 * top, colour=GREEN, label="truly standing")
        flag = run.contact_flag[:, side] > 0.5
        _bar(ax, run, flag, -0.16 * top, colour=BLUE, label="estimated contact")
        ax.set_ylabel(f"{FEET[side]} [N]")
        ax.set_ylim(-0.25 * top, 1.15 * top)
    return _with_legend(figure, axes[0])


def _figure(run: Run, title: str, rows: int, columns: int = 1) -> tuple[Figure, list[Axes]]:
    """Return a figure and its axes over time, segments shaded and a fall marked."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=SIZE, layout="constrained")
    FigureCanvasAgg(figure)
    fell = f" (fell at {run.fall_time:.2f} s)" if run.fall_time is not None else ""
    figure.suptitle(f"{run.scenario.name}: {title[0].lower()}{title[1:]}{fell}", fontsize=14)
    axes: list[Axes] = list(figure.subplots(rows, columns, sharex=True, squeeze=False).flat)
    end = float(run.time[-1])
    ends = np.concatenate([[0.0], np.cumsum([s.duration for s in run.scenario.segments])])
    for i, ax in enumerate(axes):
        for k, (begin, stop) in enumerate(pairwise(ends)):
            if begin < end:
                ax.axvspan(begin, min(stop, end), color=str(0.97 - 0.05 * (k % 2)), lw=0, zorder=0)
                if i < columns:
                    span = (begin, min(stop, end))
                    _name_segment(ax, run.scenario.segments[k].name, span, columns)
        if run.fall_time is not None:
            ax.axvline(run.fall_time, color=RED, lw=3.0)
        ax.set_xlim(0.0, max(end, 1e-3) * (1.01 if run.fell else 1.0))
        ax.grid(color="0.8", lw=0.5)
        if i >= len(axes) - columns:
            ax.set_xlabel("time [s]")
    return figure, axes


def _name_segment(ax: Axes, name: str, span: tuple[float, float], columns: int) -> None:
    """Write a segment's name over it, slanted: names are longer than short segments."""
    at = ax.get_xaxis_transform()
    rotation = 20.0 if columns == 1 else 50.0
    style: dict[str, Any] = {"rotation": rotation, "rotation_mode": "anchor", "fontsize": 8}
    ax.text(0.7 * span[0] + 0.3 * span[1], 1.03, name, transform=at, clip_on=False, **style)


def _with_legend(figure: Figure, ax: Axes) -> Figure:
    """Return the figure with the legend of one of its axes below all of them."""
    handles, labels = ax.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    return figure


def _bar(ax: Axes, run: Run, flags: Flags, at: float, *, colour: str, label: str) -> None:
    """Draw a thick line at height `at` wherever `flags` is true."""
    height = np.full(len(flags), np.nan)
    for begin, end in intervals(flags):
        height[begin:end] = at
    ax.plot(run.time, height, color=colour, lw=5.0, solid_capstyle="butt", label=label)


def _at_least(ax: Axes, reach: float) -> None:
    """Keep the vertical axis from zooming into less than `reach` on either side of 0."""
    low, high = ax.get_ylim()
    ax.set_ylim(min(low, -reach), max(high, reach))


def smoothed_velocity(run: Run, position: Array) -> tuple[Array, Array]:
    """Return times and the mean velocity around them in the heading frame.

    At both ends of the run the window is cut, down to one half of it.

    Args:
        run: what was recorded, n samples.
        position: of the point that moves [m], shape (n, 2) or wider.

    Returns:
        Times [s], shape (m,); v_x, v_y [m/s] and turn rate [rad/s], shape (m, 3).
    """
    if len(run.time) < 2:
        return np.empty(0), np.empty((0, 3))
    times, half = np.arange(0.0, run.time[-1] + 1e-9, 0.02), 0.5 * SMOOTHING
    rows = []
    for t in times:
        first, last = np.searchsorted(run.time, [t - half - 1e-9, t + half + 1e-9])
        window = slice(first, max(last, 2))
        rows.append(mean_velocity(run.time[window], position[window], run.rpy[window, 2]))
    return times, np.array(rows)
