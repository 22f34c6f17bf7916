"""The plots of a run over time: what their panels show, however they are drawn."""

from collections.abc import Iterator
from itertools import accumulate

import numpy as np
from scipy.spatial.transform import Rotation

from drake_linefoot.lab.results.contact_events import standing
from drake_linefoot.lab.results.gait_figures import flight_times
from drake_linefoot.lab.results.panels import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    RED,
    Line,
    Panel,
    Plot,
    line,
)
from drake_linefoot.lab.results.pressure import pressure_plot
from drake_linefoot.lab.results.thresholds import thresholds_of
from drake_linefoot.lab.simulation.recording import CHANNELS, DERIVED, Run
from drake_linefoot.lab.simulation.run_view import robot_of
from drake_linefoot.lab.simulation.velocity import mean_velocity
from drake_linefoot.robot.scaling import unit_value, units_of
from drake_linefoot.types import Array

FEET = ("left foot", "right foot")
LIGHT_ORANGE, LIGHT_GREEN = "#f0bd80", "#7fb992"
SIDES = {"left": RED, "right": BLUE}
OTHER_COLOURS = ("#7b4fa3", "#8c564b", "#d65fa8", "#6b6b6b", "#a3a01f", "#17a0b0")
JOINT_COLOURS = (BLUE, ORANGE, GREEN, RED, *OTHER_COLOURS)
MOST_SEGMENTS = 40  # that are drawn each by itself
TIME_LABEL = f"time [{CHANNELS['time'].unit}]"


def pictures(run: Run) -> dict[str, Plot]:
    """Return the plots that are written as pictures, by the names of the files."""
    return {
        "velocity": velocity(run, "torso", run.q[:, 4:6]),
        "orientation": orientation(run),
        "wrenches": forces(run),
        "torques": torques(run),
        "contact": contact(run),
        "pressure": pressure_plot(run),
    }


def velocity(run: Run, point: str, position: Array) -> Plot:
    """Commanded and measured velocity of a point of the robot, which `smoothed_velocity` takes."""
    smoothing = thresholds_of(run).smoothing
    time, measured = smoothed_velocity(run, position, smoothing)
    base = units_of(robot_of(run))
    units = CHANNELS["reference_command"].unit.split(", ")
    panels = []
    for i, label in enumerate(("forward", "left", "turn rate")):
        lines = [
            line("commanded", run.time, run.command[:, i], GREY, style="--"),
            line("after limits", run.time, run.reference_command[:, i], ORANGE),
            line(f"measured, mean over {smoothing:.3g} s", time, measured[:, i], BLUE),
        ]
        least = 0.1 * unit_value(units[i], base)
        panels.append(Panel(label, units[i], lines, include=(-least, least)))
    return Plot(f"Velocity of the {point}, in the heading frame", panels)


def orientation(run: Run) -> Plot:
    """Roll, pitch and yaw of the torso with their references."""
    level = np.zeros(len(run.time))
    references = {"roll": level, "pitch": level, "yaw": np.unwrap(run.reference_yaw)}
    panels = []
    for i, (label, reference) in enumerate(references.items()):
        lines = [
            line("reference", run.time, reference, GREY, style="--"),
            line("measured", run.time, run.rpy[:, i], BLUE),
        ]
        panels.append(Panel(label, DERIVED["rpy"].unit, lines, include=(-0.02, 0.02)))
    return Plot("Orientation of the torso", panels)


def forces(run: Run) -> Plot:
    """Normal force of each foot: planned, true, estimated, and what the controller counts on."""
    normal = {
        "planned by the MPC": (run.mpc_wrench, LIGHT_ORANGE, 4.0),
        "true": (run.true_force, GREEN, 1.8),
        "estimated": (run.contact_wrench, RED, 0.8),
        "whole-body controller": (run.wbc_wrench, BLUE, 0.7),
    }
    panels, air = [], flight_times(run)
    for side, label in enumerate(FEET):
        lines = [
            line(name, run.time, force[:, side, 2], colour, width)
            for name, (force, colour, width) in normal.items()
        ]
        top, unit = _largest_force(run, side), CHANNELS["true_force"].unit
        panels.append(Panel(label, unit, lines, (-0.1 * top, 1.15 * top), flights=air))
    return Plot("Normal force of each foot", panels)


def contact(run: Run) -> Plot:
    """Estimated normal force and contact flag against the truth."""
    panels, air = [], flight_times(run)
    for side, label in enumerate(FEET):
        true, top = run.true_force[:, side, 2], _largest_force(run, side)
        stands = np.where(standing(run.time, true, thresholds_of(run)), -0.08 * top, np.nan)
        flag = np.where(run.contact_flag[:, side] > 0.5, -0.16 * top, np.nan)
        lines = [
            line("true normal force", run.time, true, LIGHT_GREEN, 2.5),
            line("estimated normal force", run.time, run.contact_wrench[:, side, 2], BLUE, 0.8),
            line("truly standing", run.time, stands, GREEN, 5.0),
            line("estimated contact", run.time, flag, BLUE, 5.0),
        ]
        unit, span = CHANNELS["true_force"].unit, (-0.25 * top, 1.15 * top)
        panels.append(Panel(label, unit, lines, span, flights=air))
    return Plot("Contact estimate against the truth", panels)


def torques(run: Run) -> Plot:
    """Torque of every joint with its limits, left and right in one panel."""
    panels: dict[str, Panel] = {}
    for joint, (side, name) in enumerate(_sides_and_joints(run)):
        limit = run.effort_limits[joint]
        if name not in panels:
            span = (-1.15 * limit, 1.15 * limit)
            panels[name] = Panel(name, CHANNELS["torque"].unit, _limit_lines(run, limit), span)
        torque = line(side, run.time, run.torque[:, joint], SIDES[side], 0.7)
        panels[name].lines.append(torque)
    return Plot("Joint torques", list(panels.values()), columns=3)


def torque_shares(run: Run) -> Plot:
    """Torque of every joint over its limit, left and right in two panels."""
    unit = "% of limit"
    panels = {side: Panel(side, unit, _limit_lines(run, 100.0), (-110.0, 110.0)) for side in SIDES}
    colours: dict[str, str] = {}
    for joint, (side, name) in enumerate(_sides_and_joints(run)):
        colour = colours.setdefault(name, JOINT_COLOURS[len(colours) % len(JOINT_COLOURS)])
        share = 100.0 * run.torque[:, joint] / run.effort_limits[joint]
        panels[side].lines.append(line(name, run.time, share, colour, 1.0))
    return Plot("Joint torques as a share of their limits", list(panels.values()))


def estimation(run: Run) -> Plot:
    """Error of the estimated state with its 3 sigma, and the NIS of the innovations."""
    quaternions = run.estimate_pose[:, :4]
    is_none = ~(_size(quaternions) > 0.0)
    rotation = Rotation.from_quat(np.where(is_none[:, None], 1.0, quaternions), scalar_first=True)
    turn = (rotation * Rotation.from_quat(run.q[:, :4], scalar_first=True).inv()).as_rotvec()
    turn[is_none] = np.nan
    errors = {
        "tilt": (_size(turn[:, :2]), "rad", slice(0, 2)),
        "heading": (np.abs(turn[:, 2]), "rad", slice(2, 3)),
        "velocity": (_size(run.estimate_velocity[:, 3:] - run.v[:, 3:6]), "m/s", slice(3, 6)),
        "position": (_size(run.estimate_pose[:, 4:] - run.q[:, 4:7]), "m", slice(6, 9)),
    }
    panels = []
    for label, (error, unit, part) in errors.items():
        sigma = 3.0 * _size(run.estimate_sigma[:, part])
        lines = [
            Line("3 sigma", run.time, sigma, GREY, style="--"),
            Line("error", run.time, error, BLUE),
        ]
        panels.append(Panel(label, unit, lines, include=(0.0,)))
    known = np.isfinite(run.estimate_nis).any(axis=1)
    nis = Line("mean of the points", run.time[known], np.nanmean(run.estimate_nis[known], 1), BLUE)
    panels.append(Panel("NIS of a contact point", "-", [nis], include=(0.0, 9.0)))
    return Plot("Error of the estimated state", panels)


def _size(vectors: Array) -> Array:
    """Return the lengths of vectors, shape (n, m)."""
    return np.asarray(np.linalg.norm(vectors, axis=1))


def solvers(run: Run) -> Plot:
    """Wall time of both programs; a cross where one was not solved."""
    panels = []
    for label, channel, failed in (
        ("MPC", "mpc_ms", np.diff(run.mpc_failures, prepend=0.0) > 0.0),
        ("whole-body controller", "wbc_ms", run.wbc_success == 0.0),
    ):
        milliseconds = getattr(run, channel)
        known = ~np.isnan(milliseconds)
        name = f"not solved ({np.count_nonzero(failed)})"
        lines = [
            line("wall time", run.time[known], milliseconds[known], BLUE, 1.0),
            line(name, run.time[failed], np.nan_to_num(milliseconds[failed]), RED, style="x"),
        ]
        panels.append(Panel(label, CHANNELS[channel].unit, lines, include=(0.0,)))
    return Plot("Solver times and failures", panels)


def segment_spans(run: Run) -> Iterator[tuple[str, float, float]]:
    """Yield name, begin and end [s] of every segment that was begun.

    Of many, equal numbers are drawn as one, which is called as its first and its last.
    """
    last = max(float(run.time[-1]), 1e-3)
    ends = [*accumulate((s.duration for s in run.scenario.segments), initial=0.0)]
    begun = [s.name for s, begin in zip(run.scenario.segments, ends, strict=False) if begin < last]
    together = max(1, -(-len(begun) // MOST_SEGMENTS))
    for i in range(0, len(begun), together):
        names = begun[i : i + together]
        name = names[0] if len(names) == 1 else f"{names[0]} to {names[-1]}"
        yield name, ends[i], min(ends[i + len(names)], last)


def time_span(run: Run) -> tuple[float, float]:
    """Return what the axis of time shows [s]; a fall at its end has room."""
    return 0.0, max(float(run.time[-1]), 1e-3) * (1.01 if run.fell else 1.0)


def smoothed_velocity(run: Run, position: Array, window: float) -> tuple[Array, Array]:
    """Return times and the mean velocity around them in the heading frame.

    At both ends of the run the window is cut, down to one half of it.

    Args:
        run: what was recorded, n samples.
        position: of the point that moves [m], shape (n, 2) or wider.
        window: length of the stretch around a time [s]; less at both ends.

    Returns:
        Times [s], shape (m,); v_x, v_y [m/s] and turn rate [rad/s], shape (m, 3).
    """
    if len(run.time) < 2:
        return np.empty(0), np.empty((0, 3))
    samples, yaw = run.time, run.rpy[:, 2]
    times, half = np.arange(0.0, samples[-1] + 1e-9, 0.02), 0.5 * window
    rows = []
    for t in times:
        first, last = np.searchsorted(samples, [t - half - 1e-9, t + half + 1e-9])
        last = max(last, 2)
        near = slice(min(first, last - 2), last)
        rows.append(mean_velocity(samples[near], position[near], yaw[near]))
    return times, np.array(rows)


def _limit_lines(run: Run, limit: float) -> list[Line]:
    """Return the lines of a torque limit in both directions."""
    ends = run.time[[0, -1]]
    return [line("limit", ends, np.full(2, sign * limit), GREY, 1.0, "--") for sign in (1.0, -1.0)]


def _sides_and_joints(run: Run) -> list[tuple[str, str]]:
    """Return the side of each actuated joint, and its name in words, which is the left one's."""
    d = robot_of(run).description
    lefts = {right: str(left) for left, (right, _) in d.mirror.items() if right != left}
    found = []
    for name in d.actuated_joints:
        left = run.joint_names[d.actuated_joints.index(lefts.get(name, name))]
        words = left.removeprefix("left_").replace("_", " ")
        found.append(("right" if name in lefts else "left", words))
    return found


def _largest_force(run: Run, side: int) -> float:
    return max(float(np.nanmax(run.true_force[:, side, 2])), 2.0 * thresholds_of(run).load)
