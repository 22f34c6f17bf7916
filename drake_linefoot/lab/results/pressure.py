"""Where the centre of pressure of each foot is in its sole, and how often at the edge."""

import numpy as np

from drake_linefoot.axes import FEET, TAU_Y
from drake_linefoot.lab.results.panels import BLUE, GREEN, GREY, ORANGE, Panel, Plot, line
from drake_linefoot.lab.results.thresholds import thresholds_of
from drake_linefoot.lab.simulation.foot_points import centre_of_pressure
from drake_linefoot.lab.simulation.recording import CHANNELS, Run
from drake_linefoot.lab.simulation.run_view import robot_of
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.types import Array, Flags

AT_EDGE = 0.05  # [-] of half the sole that is believed in: so near to its edge is at it
DIRECTIONS = ("ahead", "left")


def half_size(humanoid: Humanoid, margin: float = 0.0) -> Array:
    """Return half the length of a foot and, of a sole, half its width, less a margin [m]."""
    size = np.array([humanoid.half_length, humanoid.half_width])
    return size[size > 0.0] - margin


def true_pressure(run: Run) -> Array:
    """Return where the ground presses on each foot, from the middle of its sole [m].

    Returns:
        Ahead and, of a sole, to the left, shape (n, 2, 1) or (n, 2, 2); NaN where a foot bears no
        load, see `Thresholds.load`.
    """
    size = half_size(robot_of(run))
    places = centre_of_pressure(run.true_normal)[..., : len(size)] * size
    loaded = run.true_normal.sum(axis=2, keepdims=True) > thresholds_of(run).load
    return np.where(loaded, places, np.nan)


def wanted_pressure(run: Run) -> Array:
    """Return where the whole-body controller counts on it, likewise."""
    wrench, size = run.wbc_wrench, half_size(robot_of(run))
    moments = np.stack([-wrench[..., TAU_Y], wrench[..., -1]], axis=-1)[..., : len(size)]
    loaded = wrench[..., 2:3] > thresholds_of(run).load
    return np.asarray(moments / np.where(loaded, wrench[..., 2:3], np.nan))


def cop_at_edge(run: Run) -> dict[str, float | None]:
    """Return in which share of its loaded ticks the pressure on a foot was at its edge [-].

    The edge is that which the controller believes in; at it is what is nearer than `AT_EDGE` of
    the half size, or beyond. Along a line there are two edges, round a sole four.

    Returns:
        Of each foot by its name; None for one without load.
    """
    humanoid = robot_of(run)
    edges = (1.0 - AT_EDGE) * half_size(humanoid, humanoid.description.contact_margin)
    places = true_pressure(run)
    loaded: Flags = np.asarray(np.isfinite(places).all(axis=2))
    beyond: Flags = np.asarray((np.abs(places) >= edges).any(axis=2))
    return {
        name: float(beyond[loaded[:, side], side].mean()) if loaded[:, side].any() else None
        for side, name in enumerate(FEET)
    }


def pressure_plot(run: Run) -> Plot:
    """Centre of pressure of each foot, along its length and, of a sole, across it."""
    humanoid, unit = robot_of(run), CHANNELS["contact_points"].unit
    margin = humanoid.description.contact_margin
    true, wanted, ends = true_pressure(run), wanted_pressure(run), run.time[[0, -1]]
    panels = []
    for side, foot in enumerate(FEET):
        for k, half in enumerate(half_size(humanoid)):
            lines = [
                line("edge", ends, np.full(2, sign * half), GREY, 1.0, "--") for sign in (1, -1)
            ]
            if margin:
                lines += [
                    line("less the margin", ends, np.full(2, sign * (half - margin)), ORANGE, 1.0)
                    for sign in (1, -1)
                ]
            lines += [
                line("true", run.time, true[:, side, k], GREEN, 1.8),
                line("whole-body controller", run.time, wanted[:, side, k], BLUE, 0.7),
            ]
            span = (-1.3 * half, 1.3 * half)
            panels.append(Panel(f"{foot} foot, {DIRECTIONS[k]}", unit, lines, span))
    return Plot("Centre of pressure in each sole", panels)
