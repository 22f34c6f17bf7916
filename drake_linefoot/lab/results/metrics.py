"""What a run amounts to, in numbers."""

from collections.abc import Iterator
from typing import Any, NamedTuple, Self

import numpy as np

from drake_linefoot.lab.results.contact_events import (
    Detection,
    detection,
    largest_slip,
    touchdowns,
)
from drake_linefoot.lab.results.gait_figures import (
    GaitSamples,
    gait_figures,
    standing_feet,
)
from drake_linefoot.lab.results.pressure import cop_at_edge
from drake_linefoot.lab.results.stops import long_at_stops
from drake_linefoot.lab.results.thresholds import Thresholds, thresholds_of
from drake_linefoot.lab.simulation.channels import LIMITS
from drake_linefoot.lab.simulation.recording import Run
from drake_linefoot.lab.simulation.velocity import mean_velocity
from drake_linefoot.types import Array, Flags, Indices

SLOWED = 0.01  # [-] of the time; what was slowed for less is not worth a word


def compute_metrics(run: Run) -> dict[str, Any]:
    """Return the figures of a run; every value is what JSON can hold.

    Returns:
        `duration_s`, `fell`, `fall_time_s`, `fall_reason`; `roll_max_rad`, `pitch_max_rad`;
        `segments`: per segment its name, the commanded [v_x, v_y, turn rate] in m/s and rad/s,
        the measured one (see `segment_velocity`; None when the run ended before), the error,
        measured minus commanded, whether it is `off_course`, and its `gait`, see `gait_figures`;
        `solver_failures`: MPC updates and controller ticks without a solution; `mpc_ms`,
        `wbc_ms`: wall times; `realtime_rate`; `contact`: the estimator against the truth (see
        `contact_events.detection`; the latency is the median);
        `slip_m` (see `contact_events.largest_slip`); `cop_at_edge`: see there;
        `torque_max_ratio`: of torque to limit; `torque_at_limit`: see `GaitSamples.share_at_limit`;
        `final_joint_speed_rms` in rad/s at the end (`Thresholds.settled`); `limited`:
        ticks in which a command was clipped, ticks in which a foothold was moved to a reachable
        place, and torques cut at their limit; `slowed`: for each reason for which the gait followed
        another command, `why`, the `share` of the time and the mean `speed` [m/s] that it had then,
        see `slowed`; `joints_at_stops`: see `long_at_stops`; `steps`: touchdowns after a swing.
        What the controller does not report is None; of a run without a sample, everything but how
        it ended is.
    """
    stands = standing_feet(run)
    samples = GaitSamples.of(run, stands)
    limits = samples.limits
    known, end = len(run.time) > 0, float(run.time[-1:].sum())
    joint_speed = run.v[run.time >= end - limits.settled, 6:]
    slip = largest_slip(run.contact_points, run.true_normal, limits)
    return {
        "duration_s": end,
        "fell": run.fell,
        "fall_time_s": run.fall_time,
        "fall_reason": run.fall_reason,
        "roll_max_rad": float(np.abs(run.rpy[:, 0]).max()) if known else None,
        "pitch_max_rad": float(np.abs(run.rpy[:, 1]).max()) if known else None,
        "segments": _segments(run, samples),
        "solver_failures": {
            "mpc": _count(run.mpc_failures[-1:]),
            "wbc": _count(1.0 - run.wbc_success),
        },
        "mpc_ms": _spread(run.mpc_ms),
        "wbc_ms": _spread(run.wbc_ms),
        "realtime_rate": run.realtime_rate,
        "contact": _contact(run, stands),
        "slip_m": slip if known else None,
        "cop_at_edge": cop_at_edge(run),
        "torque_max_ratio": _largest_share(run.torque, run.effort_limits) if known else None,
        "torque_at_limit": samples.share_at_limit(),
        "final_joint_speed_rms": float(np.sqrt(np.mean(joint_speed**2))) if known else None,
        "limited": {
            "commands": _count(run.clipped_commands[-1:]),
            "footholds": _count(run.moved_footholds[-1:]),
            "torques": _count(run.clipped_torques),
        },
        "slowed": slowed(run),
        "joints_at_stops": long_at_stops(run, limits),
        "steps": sum(len(touchdowns(flags)) for flags in stands),
    }


class _Samples(NamedTuple):
    """What velocities of segments are taken from, read once for all."""

    time: Array  # [s], shape (n,)
    com: Array  # [m], shape (n, 3)
    yaw: Array  # [rad], shape (n,)
    touchdowns: list[Indices]  # of each foot

    @classmethod
    def of(cls, run: Run, stands: tuple[Flags, Flags] | None) -> Self:
        """Read them; `stands` is when each foot does, found when None."""
        landed = [touchdowns(flags) for flags in stands or standing_feet(run)]
        return cls(run.time, run.com, run.rpy[:, 2], landed)

    def window(self, start: float, end: float) -> slice | None:
        """Return the samples in which a segment is measured: the second half of it.

        The window is cut to whole strides, from one touchdown of a foot to a later one of the same
        foot, so that the sway within a stride cancels; without two of them all of it is used.

        Args:
            start: of the segment [s].
            end: of the segment [s].

        Returns:
            First sample to the one after the last; None when the run ended before `end`.
        """
        middle = 0.5 * (start + end)
        first, last = np.searchsorted(self.time, [middle - 1e-9, end - 1e-9])
        if last >= len(self.time) or last == first:
            return None
        strides = []
        for landed in self.touchdowns:
            inside = landed[slice(*np.searchsorted(landed, [first, last + 1]))]
            if len(inside) > 1:
                strides.append((inside[0], inside[-1]))
        if strides:
            first, last = max(strides, key=lambda pair: pair[1] - pair[0])
        return slice(int(first), int(last) + 1)

    def velocity(self, window: slice | None) -> Array | None:
        """Return v_x, v_y in the heading frame [m/s] and the turn rate [rad/s], shape (3,)."""
        if window is None:
            return None
        return mean_velocity(self.time[window], self.com[window], self.yaw[window])


def segment_velocity(
    run: Run, start: float, end: float, stands: tuple[Flags, Flags] | None = None
) -> Array | None:
    """Return the CoM's mean velocity over whole strides of the second half of a segment.

    Args:
        run: what was recorded.
        start: of the segment [s].
        end: of the segment [s].
        stands: when each foot does, shapes (n,); found when None.

    Returns:
        v_x, v_y in the heading frame [m/s], turn rate [rad/s], shape (3,); None when the run ended
        before `end`.
    """
    samples = _Samples.of(run, stands)
    return samples.velocity(samples.window(start, end))


def slowed(run: Run) -> list[dict[str, Any]]:
    """Return for which reasons the gait followed another command than the one that was given.

    Returns:
        For each, the one that lasted longest first: `why`, one of `LIMITS`; `share` of the time in
        which it was told to walk, at least 1 % [-]; `speed` of the command it
        followed then, the mean [m/s].
    """
    walks = run.command[:, 3] > 0.5
    speed = np.hypot(run.reference_command[:, 0], run.reference_command[:, 1])
    found = []
    for number, why in enumerate(LIMITS):
        there = walks & (run.reference_limited == number)
        share = float(np.sum(there)) / max(float(np.sum(walks)), 1.0)
        if number and share >= SLOWED:
            found.append({"why": why, "share": share, "speed": float(speed[there].mean())})
    return sorted(found, key=lambda part: -float(part["share"]))


class SegmentVelocity(NamedTuple):
    """What a segment of a scenario was told, and what it did.

    Attributes:
        name: of the segment.
        begin, end: of it [s].
        commanded: v_x, v_y [m/s], turn rate [rad/s], shape (3,).
        window: in which it is measured: whole strides of the second half.
        measured: as commanded, see `segment_velocity`; None when the run ended before.
    """

    name: str
    begin: float
    end: float
    commanded: Array
    window: slice | None
    measured: Array | None


def segment_velocities(
    run: Run, stands: tuple[Flags, Flags] | None = None
) -> Iterator[SegmentVelocity]:
    """Yield the velocities of all segments of a run, see `segment_velocity`."""
    samples, end = _Samples.of(run, stands), 0.0
    for segment in run.scenario.segments:
        start, end = end, end + segment.duration
        commanded = np.array([*segment.velocity, segment.turn_rate])
        window = samples.window(start, end)
        yield SegmentVelocity(segment.name, start, end, commanded, window, samples.velocity(window))


def off_course(segment: SegmentVelocity, limits: Thresholds) -> float:
    """Return how far a segment is from its command, 1 where that counts [-].

    An error counts where it is as large as the command, as that of a walk that goes the other way,
    or of one that does not stop.
    """
    if segment.measured is None:
        return 0.0
    error, told = segment.measured - segment.commanded, segment.commanded
    along = np.hypot(*error[:2]) / max(np.hypot(*told[:2]), limits.astray)
    return float(max(along, abs(error[2]) / max(abs(told[2]), limits.turned)))


def _segments(run: Run, samples: GaitSamples) -> list[dict[str, Any]]:
    rows, limits = [], samples.limits
    for segment in segment_velocities(run, samples.stands):
        name, commanded, measured = segment.name, segment.commanded, segment.measured
        rows.append(
            {
                "name": name,
                "commanded": commanded.tolist(),
                "measured": None if measured is None else measured.tolist(),
                "error": None if measured is None else (measured - commanded).tolist(),
                "off_course": off_course(segment, limits) > 1.0,
                "gait": gait_figures(run, samples, segment.window, measured),
            }
        )
    return rows


def _contact(run: Run, stands: tuple[Flags, Flags]) -> dict[str, float | int | None]:
    if np.isnan(run.contact_flag).all():
        return {"latency_ms": None, "false_positives": None, "missed": None}
    limits = thresholds_of(run)
    loaded = run.true_normal.sum(axis=2) > limits.load
    feet: list[Detection] = [
        detection(run.time, flags, run.contact_flag[:, side] > 0.5, limits, loaded[:, side])
        for side, flags in enumerate(stands)
    ]
    latencies = np.concatenate([foot.latencies for foot in feet])
    return {
        "latency_ms": 1e3 * float(np.median(latencies)) if len(latencies) else None,
        "false_positives": sum(foot.false_positives for foot in feet),
        "missed": sum(foot.missed for foot in feet),
    }


def _largest_share(values: Array, limits: Array) -> float:
    """Return the largest share of the limits of columns; what is not finite is left out."""
    finite = np.isfinite(values)
    high = np.max(values, axis=0, initial=0.0, where=finite)
    low = np.min(values, axis=0, initial=0.0, where=finite)
    return float(np.fmax.reduce(np.maximum(high, -low) / limits, initial=0.0))


def _count(values: Array) -> int | None:
    """Return the sum of counts; None where there is none, or one is not known."""
    total = float(np.sum(values))
    return None if np.isnan(total) or not len(values) else round(total)


def _spread(values: Array) -> dict[str, float | None]:
    """Return median and 95th percentile; NaN is left out."""
    values = values[~np.isnan(values)]
    if not len(values):
        return {"median": None, "p95": None}
    return {"median": float(np.median(values)), "p95": float(np.percentile(values, 95))}
