"""Pictures of the study: speeds, pushes, and a run over time."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from drake_linefoot.lab.results.panels import FLIGHT, SHADE
from drake_linefoot.lab.results.plots import FEET, SIDES
from studies.common.drawing import BLUE, GREEN, GREY, ORANGE, RED, array, blank, legend
from studies.common.types import Data
from studies.running.cases import PHASE, PUSHED


def draw_speeds(ladders: Mapping[str, Sequence[Data]]) -> Figure:
    """Return speed, flight, torques and cost over the commanded speed, of walk and run."""
    figure, axes = blank("Forward: a walk, and a run", 2, 2)
    panels = {
        "measured [m/s]": "measured",
        "flight, smallest [ms]": "flight",
        "a torque at its limit [% of the ticks]": "limited",
        "cost of transport, positive work [-]": "cost",
    }
    scale = {"flight": 1e3, "limited": 100.0}
    for ax, (label, key) in zip(axes, panels.items(), strict=True):
        for name, colour in (("walk_forward", ORANGE), ("run_forward", BLUE)):
            rungs = ladders[name]
            sizes = array([rung["size"] for rung in rungs])
            values = scale.get(key, 1.0) * array([rung[key] for rung in rungs])
            holds = np.array([rung["holds"] for rung in rungs], dtype=bool)
            ax.plot(sizes, values, color=colour, lw=1.0, label=name.removesuffix("_forward"))
            ax.plot(sizes[holds], values[holds], "o", color=colour)
            ax.plot(sizes[~holds], values[~holds], "x", color=colour)
        if key == "measured":
            ends = array(ax.get_xlim())
            ax.plot(ends, ends, color=GREY, lw=0.8, ls="--", label="as commanded")
        ax.set_ylabel(label)
        ax.set_xlabel("commanded [m/s]")
    return legend(figure, axes[0])


def draw_pushes(rows: Sequence[Data]) -> Figure:
    """Return which pushes were survived, by direction and time of a stride."""
    figure, (ax,) = blank("Pushes of a run", 1, size=(9.0, 5.0))
    pushed = [row for row in rows if row["case"] == "run_push" and row["push"]]
    for name, colour, mark, good in (("upright", GREEN, "o", True), ("fell", RED, "x", False)):
        some = array([row["push"] for row in pushed if row["upright"] == good]).reshape(-1, 2)
        ax.plot(np.degrees(some[:, 0]), 1e3 * (some[:, 1] - PUSHED), mark, color=colour, label=name)
    ax.set_xlim(-180.0, 180.0)
    ax.set_ylim(0.0, 1e3 * PHASE)
    ax.set_xlabel("direction, 0 is ahead, 90 to the left [deg]")
    ax.set_ylabel("when, within two steps [ms]")
    return legend(figure, ax)


def draw_run(curves: Data) -> Figure:
    """Return forces on the feet, height and speed of the CoM over some steps of a run."""
    title = "A run at 2 m/s: normal forces, and the centre of mass"
    figure, axes = blank(title, 3, size=(11.0, 7.5), sharex=True)
    time, force = array(curves["time"]), array(curves["force"])
    for side, (foot, colour) in enumerate(zip(FEET, SIDES.values(), strict=True)):
        axes[0].plot(time, force[:, side], color=colour, lw=1.2, label=foot)
    axes[1].plot(time, curves["height"], color=GREEN)
    axes[2].plot(time, curves["speed"], color=BLUE)
    labels = ("normal force [N]", "height [m]", "speed [m/s]")
    for ax, label in zip(axes, labels, strict=True):
        for k, (begin, end) in enumerate(curves["flights"]):
            ax.axvspan(begin, end, color=SHADE, lw=0, zorder=0, label=None if k else FLIGHT)
        ax.set_ylabel(label)
        ax.set_xlim(time[0], time[-1])
    axes[0].set_ylim(0.0, 1.05 * float(np.percentile(force, 99.5)))
    axes[-1].set_xlabel("time [s]")
    return legend(figure, axes[0])
