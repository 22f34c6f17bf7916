"""Pictures of sweeps: success rates, and where in the space of the parameters they come from."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from drake_linefoot.gait.constants import constants_of
from drake_linefoot.gait.viability import viable_impulse
from drake_linefoot.lab.results.judge import upright
from drake_linefoot.lab.results.viability import soonest_step, step_bounds
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.simulation.run_view import humanoid_named
from drake_linefoot.lab.sweep.maps import MOST, label, numbers, rates_by_bin, successes
from drake_linefoot.lab.sweep.rows import Row
from drake_linefoot.robot.scaling import scaled
from studies.common.drawing import BLUE, GREEN, GREY, ORANGE, RED, blank
from studies.common.types import Array
from studies.robustness.summary import IMPULSE

_COLUMNS = 3


def draw_rates(summary: Mapping[str, Any]) -> Figure:
    """Return the success rate of each group with its interval, and its bar."""
    groups = {name: g for name, g in summary["groups"].items() if g["n"]}
    figure, (ax,) = blank("Runs that stay upright", 1, size=(9.0, 0.45 * len(groups) + 1.5))
    for i, (name, group) in enumerate(groups.items()):
        rate, low, high = (100.0 * group[key] for key in ("rate", "low", "high"))
        ax.barh(i, rate, color=BLUE, height=0.6)
        ax.errorbar(rate, i, xerr=[[rate - low], [high - rate]], color=ORANGE, capsize=3)
        if name in summary["bars"]:
            ax.plot([summary["bars"][name]["bar"]] * 2, [i - 0.4, i + 0.4], color=RED, lw=2.0)
    ax.set_yticks(range(len(groups)), list(groups))
    ax.invert_yaxis()
    ax.set_xlim(0.0, 104.0)
    ax.set_xlabel("upright [%], with the 95 % interval; red: the bar")
    return figure


def draw_pushes(rows: Sequence[Row], scenario: Scenario) -> Figure:
    """Return pushes by direction and impulse, and what a pendulum survives that steps in place.

    The rows are runs with one push each, of the robot and the gait of `scenario`.
    """
    humanoid = humanoid_named(scenario.robot)
    gait, c = scaled(scenario.gait, humanoid), constants_of(scenario.gait, humanoid)[0]
    bounds, mass, w = step_bounds(c), humanoid.mass, float(c.omega)
    figure = Figure(figsize=(8.0, 8.6), layout="constrained")
    ax: Any = figure.add_subplot(projection="polar", theta_offset=0.5 * np.pi)
    angles = np.linspace(-np.pi, np.pi, 145)
    step = gait.single_support + gait.double_support
    beside = gait.step_width / (1.0 + np.exp(w * step))  # the DCM when the weight comes
    impulses = [row["sampled"][IMPULSE] for row in rows]  # [N s]
    ax.set_ylim(0.0, 1.1 * max(impulses))
    for side, sign in (("left", 1.0), ("right", -1.0)):
        ways = np.column_stack([np.cos(angles), sign * np.sin(angles)])
        zeta, soonest = np.array([0.0, beside]), soonest_step(c, 0.0)
        most = [mass * viable_impulse(zeta, way, soonest, bounds) for way in ways]
        label = "bound of steps for a pendulum, a foot just lifted" if side == "left" else None
        ax.plot(angles, most, color=ORANGE, lw=2.0, label=label)
    for viable, fell, marker, color, label in (
        (True, False, "o", BLUE, "upright"),
        (True, True, "X", RED, "fell"),
        (False, False, "o", GREEN, "upright beyond what steps can save"),
        (False, True, "X", GREY, "fell beyond what steps can save"),
    ):
        some = [
            r["sampled"] for r in rows if bool(r["viable"]) is viable and upright(r) is not fell
        ]
        ax.plot(
            [one["pushes[0].direction"] for one in some],
            [one[IMPULSE] for one in some],
            marker, color=color, ms=6.0, label=f"{label}: {len(some)}",
        )  # fmt: skip
    ax.set_thetagrids([0, 90, 180, 270], ["forward", "left", "back", "right"], fontsize=13)
    ax.set_rlabel_position(22.5)
    saved = sum(map(upright, rows))
    ax.set_title(f"{saved} of {len(rows)} pushes of {min(impulses):.0f} to {max(impulses):.0f} N s "
                 f"are survived\n(m sqrt(g h) is {mass * gait.com_height * w:.3g} N s)",
                 fontsize=14)  # fmt: skip
    figure.legend(loc="outside lower center", ncols=2, fontsize=11, frameon=False)
    return figure


def draw_map(name: str, rows: Sequence[Row], units: Mapping[str, str]) -> Figure | None:
    """Return where the runs of a group stay upright; None when it samples no number.

    The first axes have every run over the two parameters that tell most of success, the others
    the success rate over one parameter each, in bins of equally many runs. `units` are of what is
    sampled, by dotted path.
    """
    sampled = numbers(rows)
    if not sampled:
        return None
    good, order = successes(rows), list(sampled)
    lines = -(-(1 + min(len(order), MOST)) // _COLUMNS)
    figure, axes = blank(f"{name}: {good.sum()} of {len(rows)} upright", lines, _COLUMNS,
                         size=(12.0, 3.4 * lines + 0.5))  # fmt: skip
    _scatter(axes[0], sampled, good, order[:2], units)
    for ax, path in zip(axes[1:], order[:MOST], strict=False):
        _rates(ax, sampled[path], good)
        ax.set_xlabel(label(path, units))
    for ax in axes[1 + len(order[:MOST]) :]:
        ax.set_visible(False)
    return figure


def _scatter(
    ax: Axes,
    sampled: Mapping[str, Array],
    good: NDArray[np.bool_],
    paths: Sequence[str],
    units: Mapping[str, str],
) -> None:
    x = sampled[paths[0]]
    y = sampled[paths[1]] if len(paths) > 1 else np.arange(len(x), dtype=float)
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
