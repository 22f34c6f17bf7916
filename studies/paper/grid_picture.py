"""The maps of the grid: where which model falls, and how much steadier the ECD is."""

import math

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from studies.common.drawing import blank
from studies.common.types import Data
from studies.paper.figure import shown
from studies.paper.statistic import mean

MAPS = {"roll_rms": "roll", "pitch_rms": "pitch"}
BOTH, ONE, OTHER = "#555555", "#2e7d32", "#b3261e"  # both fall, only the base, only the ECD
LEAST, MOST = 0.2, 5.0  # [-] ratios at the ends of the colours


def draw(data: Data, title: str, pairs: dict[str, str]) -> Figure:
    """Draw one map of ratios for each angle and each choice of weights."""
    heading = (
        f"{title}\nRMS of the ECD over that of the single rigid body; below 1 the ECD is steadier"
    )
    count = len(data["points"])
    rows = {(*p["step"], p["legs"]) for p in data["points"]}
    commands = {tuple(p["command"]) for p in data["points"]}
    size = (max(15.0, 5.0 + 2.5 * len(commands)), 3.6 + 0.5 * len(rows) * len(pairs))
    figure, axes = blank(heading, len(pairs), len(MAPS), size)
    for i, (weights, words) in enumerate(pairs.items()):
        for j, (quantity, name) in enumerate(MAPS.items()):
            ax = axes[i * len(MAPS) + j]
            found = data["over_points"][weights]["ecd_over_srbm"][quantity]
            all_of = f"{mean(found)}, pooled {shown(found['pooled'], '.2f')}"
            title = f"{name}, {words}:\ngeometric mean {all_of} where both stand"
            ax.set_title(title, fontsize=10)
            _map(ax, data, weights, quantity)
    falls = "; ".join(
        f"{words}: ECD falls at {data['falls'][w]['ecd']}, single body at "
        f"{data['falls'][w]['srbm']} of {count}"
        for w, words in pairs.items()
    )
    figure.supxlabel(falls, fontsize=10)
    return figure


def _map(ax: Axes, data: Data, weights: str, quantity: str) -> None:
    """Draw one cell for each point, commands to the right."""
    from matplotlib.patches import Rectangle

    commands = sorted(
        {tuple(p["command"]) for p in data["points"]}, key=lambda c: (c[2], c[1], c[0])
    )
    rows = sorted({(tuple(p["step"]), p["legs"]) for p in data["points"]})
    for point in data["points"]:
        x = commands.index(tuple(point["command"]))
        y = rows.index((tuple(point["step"]), point["legs"]))
        text, colour, ink = _cell(point["runs"][weights], quantity)
        ax.add_patch(Rectangle((x - 0.48, y - 0.46), 0.96, 0.92, color=colour))
        ax.text(x, y, text, ha="center", va="center", fontsize=8, color=ink)
    ax.set_xlim(-0.5, len(commands) - 0.5)
    ax.set_ylim(-0.5, len(rows) - 0.5)
    labels = [
        f"{vx:g} m/s"
        + (f",\n{vy:g} m/s left" if vy else "")
        + (f",\n{turn:g} rad/s" if turn else "")
        for vx, vy, turn in commands
    ]
    ax.set_xticks(range(len(commands)), labels)
    shares = data["shares"]
    ax.set_yticks(
        range(len(rows)),
        [f"step {s + d:g} s, legs {100 * shares[f'{legs:g}']:.0f} %" for (s, d), legs in rows],
    )
    ax.grid(visible=False)


def _cell(runs: Data, quantity: str) -> tuple[str, str | tuple[float, float, float], str]:
    """Return text, colour of the cell and colour of the text."""
    ours, theirs = runs["ecd"], runs["srbm"]
    if ours["fell"] and theirs["fell"]:
        return f"both fall\n{ours['fall_time']:.1f} s, {theirs['fall_time']:.1f} s", BOTH, "white"
    if theirs["fell"]:
        return f"single body falls\nat {theirs['fall_time']:.1f} s", ONE, "white"
    if ours["fell"]:
        return f"ECD falls\nat {ours['fall_time']:.1f} s", OTHER, "white"
    value = ours[quantity] / theirs[quantity]
    return f"{value:.2f}", shade(value), "black"


def shade(value: float) -> tuple[float, float, float]:
    """Return a colour from green (the ECD is steadier) over white to red."""
    share = math.log(min(max(value, LEAST), MOST)) / math.log(MOST)
    if share < 0.0:
        return (1.0 + 0.55 * share, 1.0 + 0.15 * share, 1.0 + 0.55 * share)
    return (1.0, 1.0 - 0.5 * share, 1.0 - 0.5 * share)
