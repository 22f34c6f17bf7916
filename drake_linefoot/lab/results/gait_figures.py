"""What a gait amounts to in numbers: flights, duty factor, Froude number, cost of transport."""

from itertools import pairwise
from typing import Any, NamedTuple, Self

import numpy as np

from drake_linefoot.constants import STANDARD_GRAVITY
from drake_linefoot.lab.results.contact_events import intervals, standing, touchdowns
from drake_linefoot.lab.results.thresholds import Thresholds, thresholds_of
from drake_linefoot.lab.simulation.recording import Run
from drake_linefoot.lab.simulation.run_view import robot_of
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.types import Array, Flags, Indices

AT_LIMIT = 0.99  # [-] of a torque's limit


def standing_feet(run: Run) -> tuple[Flags, Flags]:
    """Return when each foot truly stood, see `contact_events.standing`, shapes (n,)."""
    left, right = run.true_normal.sum(axis=2).T
    limits = thresholds_of(run)
    return standing(run.time, left, limits), standing(run.time, right, limits)


def flights(time: Array, stands: tuple[Flags, Flags], limits: Thresholds) -> Indices:
    """Return the samples in which no foot stands, as half-open ranges, shape (m, 2).

    What is shorter than `Thresholds.shortest_flight` is a change of feet of a walk; what begins or
    ends a record is not known as a whole, and left out.

    Args:
        time: samples [s], shape (n,).
        stands: when each foot does, shapes (n,).
        limits: of the robot's size.
    """
    found = intervals(~(stands[0] | stands[1]))
    found = found[(found[:, 0] > 0) & (found[:, 1] < len(time))]
    lasted = time[found[:, 1]] - time[found[:, 0]]
    return found[lasted >= limits.shortest_flight - 1e-9]


def flight_times(run: Run) -> Array:
    """Return begin and end of each of `flights` [s], shape (m, 2)."""
    times: Array = run.time[flights(run.time, standing_feet(run), thresholds_of(run))]
    return times


def at_limit(run: Run) -> Flags:
    """Return whether the torque of each joint is at its limit, shape (n, na)."""
    return np.asarray(np.abs(run.torque) >= AT_LIMIT * run.effort_limits)


class GaitSamples(NamedTuple):
    """What the figures of all windows are taken from, found once for all."""

    stands: tuple[Flags, Flags]  # when each foot does, shapes (n,)
    touchdowns: list[Indices]  # of each foot
    flights: Indices  # see there
    any_at_limit: Flags  # whether the torque of any joint is at its limit, shape (n,)
    limits: Thresholds
    humanoid: Humanoid

    @classmethod
    def of(cls, run: Run, stands: tuple[Flags, Flags]) -> Self:
        """Find them; `stands` is when each foot does."""
        limits, any_joint = thresholds_of(run), np.asarray(at_limit(run).any(axis=1))
        landed, air = [touchdowns(flags) for flags in stands], flights(run.time, stands, limits)
        return cls(stands, landed, air, any_joint, limits, robot_of(run))

    def share_at_limit(self, window: slice = slice(None)) -> float | None:
        """Return in which share of the ticks any torque is at its limit; None without a tick."""
        any_joint = self.any_at_limit[window]
        return float(any_joint.mean()) if len(any_joint) else None


def work(run: Run, window: slice, humanoid: Humanoid) -> tuple[float, float]:
    """Return what the joints did in a window, without what they took, and both together [J].

    Args:
        run: what was recorded.
        window: first sample to the one after the last.
        humanoid: the robot of the run.
    """
    power = run.applied_torque[window] * run.v[window][:, humanoid.actuated_v]
    done = power[1:] * np.diff(run.time[window])[:, None]  # a torque held until its sample
    return float(np.maximum(done, 0.0).sum()), float(np.abs(done).sum())


def gait_figures(
    run: Run, samples: GaitSamples, window: slice | None, velocity: Array | None
) -> dict[str, Any] | None:
    """Return the figures of the gait in a window; None without one, or a stride in it.

    Args:
        run: what was recorded.
        samples: of the whole run.
        window: first sample to the one after the last, from a touchdown to one.
        velocity: mean of the window, forward and left first [m/s], shape (2,) or more.

    Returns:
        `flights`: how many; `flight_s`: their median, None without one; `duty_factor`: share of a
        stride in which its foot stands, median of the strides; `froude_number`: v^2 / (g h), with h
        the height of the CoM of the nominal posture; `cost_of_transport`: positive work of the
        joints by weight and way, and `cost_of_transport_absolute`, that of |power|, both None for
        what is slower than `Thresholds.astray`; `torque_at_limit`, see `GaitSamples`.
    """
    if window is None or velocity is None:
        return None
    first, last = window.start, window.stop - 1
    shares = [
        flags[begin:end].mean()
        for flags, landed in zip(samples.stands, samples.touchdowns, strict=True)
        for begin, end in pairwise(landed[slice(*np.searchsorted(landed, [first, last + 1]))])
    ]
    if not shares:
        return None
    limits, humanoid = samples.limits, samples.humanoid
    begun, ended = samples.flights.T  # both grow
    air = samples.flights[np.searchsorted(begun, first) : np.searchsorted(ended, last, "right")]
    lasted = [float(run.time[end] - run.time[begin]) for begin, end in air]
    speed = float(np.hypot(*velocity[:2]))
    weight, way = STANDARD_GRAVITY * humanoid.mass, speed * float(run.time[last] - run.time[first])
    costs = [
        joules / (weight * way) if speed > limits.astray else np.nan
        for joules in work(run, window, humanoid)
    ]
    positive, both = (cost if np.isfinite(cost) else None for cost in costs)
    return {
        "flights": len(air),
        "flight_s": float(np.median(lasted)) if lasted else None,
        "duty_factor": float(np.median(shares)),
        "froude_number": speed**2 / (STANDARD_GRAVITY * humanoid.com_height),
        "cost_of_transport": positive,
        "cost_of_transport_absolute": both,
        "torque_at_limit": samples.share_at_limit(window),
    }
