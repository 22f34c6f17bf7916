"""Stances and touchdowns of a recorded run, and what the estimator made of them."""

from typing import NamedTuple

import numpy as np

from drake_linefoot.lab.results.thresholds import Thresholds
from drake_linefoot.types import Array, Flags, Indices


def intervals(flags: Flags) -> Indices:
    """Return where `flags` is true, as half-open index ranges, shape (m, 2)."""
    edges = np.diff(np.concatenate([[False], flags, [False]]).astype(int))
    return np.column_stack([np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)])


def standing(time: Array, normal: Array, limits: Thresholds) -> Flags:
    """Return whether a foot truly stands: loaded, or unloaded too briefly for a swing.

    A scuff in a swing is no stance; one shortly before a touchdown is its beginning.

    Args:
        time: samples [s], shape (n,).
        normal: true normal force of the foot [N], shape (n,).
        limits: of the robot's size.
    """
    flags: Flags = normal > limits.load
    for begin, end in intervals(~flags):
        if time[min(end, len(time) - 1)] - time[begin] < limits.shortest_swing:
            flags[begin:end] = True
    for begin, end in intervals(flags):
        if end < len(time) and time[end] - time[begin] < limits.shortest_stance:
            flags[begin:end] = False
    return flags


def touchdowns(flags: Flags) -> Indices:
    """Return the samples at which a stance begins; one that begins the run is none."""
    begins = intervals(flags)[:, 0]
    return begins[begins > 0]


class Detection(NamedTuple):
    """How the estimator saw one foot.

    A flag that was up before a touchdown is no detection, and has no latency. One is false that was
    raised in a swing without any load on the foot, or stayed on for too long after lift-off.
    """

    latencies: Array  # from each touchdown to the estimator's flag [s], shape (m,)
    missed: int  # touchdowns without a flag in time
    false_positives: int


def detection(
    time: Array, stands: Flags, flag: Flags, limits: Thresholds, loaded: Flags | None = None
) -> Detection:
    """Compare the estimator's flag of one foot with the truth.

    Args:
        time: samples [s], shape (n,).
        stands: truth, of `standing`, shape (n,).
        flag: of the estimator, shape (n,).
        limits: of the robot's size.
        loaded: whether the foot truly bears load, as scuffs do, shape (n,); `stands` without. A
            flag soon after it is not false.

    Returns:
        The comparison. A touchdown too near the end of the run to be judged is left out.
    """
    latencies, missed = [], 0
    for begin in touchdowns(stands):
        until = np.searchsorted(time, time[begin] + limits.detection_time + 1e-9)
        raised = np.flatnonzero(flag[begin:until])
        if flag[begin - 1] and flag[begin]:
            continue  # in the air already, which counts as a false one below
        if len(raised):
            latencies.append(time[begin + raised[0]] - time[begin])
        elif until < len(time):
            missed += 1
    false_positives = 0
    for begin, end in intervals(flag & ~stands):
        recent = np.searchsorted(time, time[begin] - limits.recent - 1e-9)
        touched = loaded is not None and bool(loaded[recent : begin + 1].any())
        raised_in_air = begin == 0 or (not flag[begin - 1] and not touched)
        lasted = time[min(end, len(time) - 1)] - time[begin]
        false_positives += int(raised_in_air or lasted > limits.detection_time)
    return Detection(np.array(latencies), missed, false_positives)


def largest_slip(points: Array, normal: Array, limits: Thresholds) -> float:
    """Return the largest horizontal motion of a loaded contact point [m].

    For every point and every interval in which that very point carries load: the
    largest distance from where it stood when the load came. A foot that rolls over its toe
    does not slip by this measure (but the rounding of the toe rolls, 1 mm per 0.1 rad).

    Args:
        points: of each foot [m], shape (n, 2, nc, 3).
        normal: normal force on each [N], shape (n, 2, nc).
        limits: of the robot's size.
    """
    largest = 0.0
    for at in np.ndindex(normal.shape[1:]):
        for begin, stop in intervals(normal[:, *at] > limits.load):
            path = points[begin:stop, *at, :2]
            largest = max(largest, float(np.linalg.norm(path - path[0], axis=1).max()))
    return largest
