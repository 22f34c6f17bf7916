"""What goes wrong with a walk, as seen in its record: slips, stops, late steps and the like."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from drake_linefoot.axes import FEET
from drake_linefoot.gait.constants import constants_of
from drake_linefoot.lab.results.clearance import STRIDE, leg_clearance, limb_radius
from drake_linefoot.lab.results.contact_events import intervals
from drake_linefoot.lab.results.metrics import off_course, segment_velocities
from drake_linefoot.lab.results.stops import at_stops
from drake_linefoot.lab.results.thresholds import Thresholds, thresholds_of
from drake_linefoot.lab.results.viability import capture_offset, step_bounds
from drake_linefoot.lab.simulation.recording import Run
from drake_linefoot.lab.simulation.run_view import robot_of
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.types import Flags

NO_FOOTHOLD, SLIP, SOLVER = "no reachable foothold", "slip", "solver"
JOINT_LIMIT, COLLISION, LATE = "joint limit", "self-collision", "late step"
OFF_COURSE = "off course"
CAUSES = (NO_FOOTHOLD, SLIP, SOLVER, JOINT_LIMIT, COLLISION, LATE, OFF_COURSE)

MPC_LOST, WBC_LOST = 3, 5  # updates, ticks without a solution
MOVED_SHARE = 0.5  # [-] of the ticks of a swing that aim, or of the last of them
FINAL = 20  # ticks that are the last
_SAME = 1e-7  # [m] between two positions that count as equal


class FallIndicator(NamedTuple):
    """Something that should not be."""

    name: str  # one of `CAUSES`
    begin: float  # when it was there first [s]
    end: float  # when it was there last [s]
    severity: float  # its size, 1 where it begins to count [-]
    what: str  # in words


def fall_indicators(run: Run, first: int, end: int) -> list[FallIndicator]:
    """Return what was seen within a half-open range of samples, the earliest first."""
    humanoid, limits = robot_of(run), thresholds_of(run)
    seen = [
        *_slips(run, limits, first, end),
        *_unsolved(run, first, end),
        *_at_stops(run, limits, first, end),
        *_off_course(run, limits, first, end),
        *_collisions(run, humanoid, first, end),
        *_steps(run, limits, first, end),
    ]
    seen.sort(key=lambda s: (s.begin, -s.severity))
    return seen


def _span(run: Run, first: int, end: int) -> tuple[float, float]:
    """Return the times of a range of samples, the last one's too."""
    return float(run.time[first]), float(run.time[end - 1])


def _first(flags: Flags) -> int:
    return int(np.argmax(flags))


def _slips(run: Run, limits: Thresholds, first: int, end: int) -> Iterator[FallIndicator]:
    """Yield when a point of a standing foot had slid too far while it was loaded."""
    loaded = run.true_normal[:end] > limits.load
    for foot in (0, 1):
        stands = np.asarray(loaded[:, foot].any(axis=1))
        for lands, stop in intervals(stands):
            begin = int(np.searchsorted(run.time, run.time[lands] + limits.stands))
            if begin >= stop or stop <= first:
                continue
            ways = np.diff(run.contact_points[begin:stop, foot, :, :2], axis=0)
            ways[~loaded[begin + 1 : stop, foot]] = 0.0  # rolling over one end is no slip
            slid = np.linalg.norm(np.cumsum(ways, axis=0), axis=2).max(axis=1, initial=0.0)
            if slid.max(initial=0.0) > limits.slipped:
                when = _span(run, max(begin + 1 + _first(slid > limits.slipped), first), stop)
                what = f"{FEET[foot]} foot by {1e3 * slid.max():.0f} mm"
                yield FallIndicator(SLIP, *when, float(slid.max()) / limits.slipped, what)


def _unsolved(run: Run, first: int, end: int) -> Iterator[FallIndicator]:
    """Yield when MPC or whole-body controller have had no solution too often."""
    mpc = np.diff(run.mpc_failures[first:end], prepend=run.mpc_failures[first])
    wbc = 1.0 - run.wbc_success[first:end]
    for lost, most, what in ((mpc, MPC_LOST, "MPC"), (wbc, WBC_LOST, "controller")):
        count = float(np.nansum(lost))
        at = first + np.flatnonzero(lost > 0.0)
        if len(at) >= most:
            text = f"{what} {count:.0f} times without a solution"
            yield FallIndicator(SOLVER, *_span(run, at[most - 1], at[-1] + 1), count / most, text)


def _at_stops(run: Run, limits: Thresholds, first: int, end: int) -> Iterator[FallIndicator]:
    """Yield which joints of the legs were at their stops."""
    for name, there, loaded in at_stops(run, limits, first, end):
        for begin, stop in intervals(there):
            place = "standing" if loaded[begin:stop].mean() > 0.5 else "in the air"
            when = _span(run, first + begin, first + stop)
            lasted = when[1] - when[0]
            if lasted >= limits.stopped:
                what = f"{name} {place} for {1e3 * lasted:.0f} ms"
                yield FallIndicator(JOINT_LIMIT, *when, lasted / limits.stopped, what)


def _off_course(run: Run, limits: Thresholds, first: int, end: int) -> Iterator[FallIndicator]:
    """Yield which segments that lie within the samples did something else than they were told."""
    for segment in segment_velocities(run):
        if segment.measured is None:
            continue
        begin, stop = np.searchsorted(run.time, [segment.begin + 1e-9, segment.end - 1e-9])
        if begin >= first and stop < end and (off := off_course(segment, limits)) > 1.0:
            measured, told = (
                " ".join(f"{value:.2f}" for value in values)
                for values in (segment.measured, segment.commanded)
            )
            what = f"{segment.name}: {measured} instead of {told}"
            yield FallIndicator(OFF_COURSE, segment.begin, segment.end, off, what)


def _collisions(run: Run, humanoid: Humanoid, first: int, end: int) -> Iterator[FallIndicator]:
    """Yield when the legs were inside each other."""
    gap = leg_clearance(humanoid, run.q[first:end:STRIDE])
    if gap.min() < 0.0:
        at = first + STRIDE * np.flatnonzero(gap < 0.0)
        what = f"legs {-1e3 * gap.min():.0f} mm inside each other"
        severity = 1.0 - gap.min() / limb_radius(humanoid)
        yield FallIndicator(COLLISION, *_span(run, at[0], at[-1] + 1), severity, what)


def _steps(run: Run, limits: Thresholds, first: int, end: int) -> Iterator[FallIndicator]:
    """Yield what was wrong with the steps of which the swing is, in part, within the samples."""
    air = run.planned_contact < 0.5
    swings = [(begin, stop, side) for side in (0, 1) for begin, stop in intervals(air[:, side])]
    for begin, stop, side in sorted(swings):
        if stop <= first or begin >= end:
            continue
        yield from _moved(run, limits, side, begin, min(stop, end))
        landed = _touchdown(run, limits, side, (begin + stop) // 2, end)
        late = _lateness(run, side, begin, stop, landed)
        when = _span(run, min(landed, end - 1), min(landed, end - 1) + 1)
        if late > limits.lateness:
            what = f"{1e3 * late:.0f} ms after it was due"
            yield FallIndicator(LATE, *when, late / limits.lateness, what)
        if landed >= end:
            continue
        place = run.contact_points[landed, side].mean(axis=0)
        miss = float(np.linalg.norm(place[:2] - run.foothold[min(landed, stop - 1), side, :2]))
        if miss > limits.miss:
            yield FallIndicator(
                LATE, *when, miss / limits.miss, f"{1e3 * miss:.0f} mm beside its target"
            )
        excess = beyond_capture(run, robot_of(run), side, landed)
        if excess > 1.0:
            what = f"capture point {excess:.1f} times as far as a step can reach"
            yield FallIndicator(NO_FOOTHOLD, *when, excess, what)


def _moved(
    run: Run, limits: Thresholds, side: int, begin: int, stop: int
) -> Iterator[FallIndicator]:
    """Yield when a limit moved the foothold, for much of a swing or until it was final."""
    counted = np.diff(run.moved_footholds[begin:stop]) > 0.0
    aimed = np.abs(np.diff(run.foothold[begin:stop, side, :2], axis=0)).max(axis=1) > _SAME
    if not counted.any():
        return
    last = np.flatnonzero(aimed | counted)[-1] + 1
    share = float(max(counted[:last].mean(), counted[max(last - FINAL, 0) : last].mean()))
    total = run.scenario.plant.time_step * float(counted.sum())
    severity = share / MOVED_SHARE
    if severity >= 1.0 and total >= limits.moved:
        when = _span(run, begin + 1 + _first(counted), stop)
        what = f"foothold moved by its limits for {1e3 * total:.0f} ms of a swing"
        yield FallIndicator(NO_FOOTHOLD, *when, severity, what)


def _touchdown(run: Run, limits: Thresholds, side: int, middle: int, end: int) -> int:
    """Return the first sample at which a swing foot is loaded, `end` when there is none.

    What touches before the middle of the swing has scuffed.
    """
    loaded = run.true_normal[middle:end, side].sum(axis=1) > limits.load
    return middle + _first(loaded) if loaded.any() else end


def _lateness(run: Run, side: int, begin: int, stop: int, landed: int) -> float:
    """Return how late a swing foot landed [s]: how long it reached down, or stood in the air."""
    step = np.diff(run.swing_position[begin : min(stop, landed), side], axis=0)
    dt = run.scenario.plant.time_step
    down = np.abs(step[:, 2] + run.scenario.gait.reach_speed * dt) < _SAME
    reaching = down & (np.abs(step[:, :2]).max(axis=1) < _SAME)
    return dt * float(reaching.sum() + max(landed - stop, 0))


def beyond_capture(run: Run, humanoid: Humanoid, side: int, landed: int) -> float:
    """Return how far the capture point is from a foot that lands, over what steps can capture.

    With steps as long, as wide and as quick as the legs can make any, and the weight in the middle
    of each foot, see `offset_limits`: 1 at the bound, more beyond it [-].
    """
    bounds = step_bounds(constants_of(run.scenario.gait, humanoid)[0])
    (_, most), (low, high) = bounds.offsets
    ahead, inwards = capture_offset(run, landed, side, bounds.omega)
    aside = abs(inwards - 0.5 * (low + high)) / (0.5 * (high - low))
    return float(max(abs(ahead) / most, aside))
