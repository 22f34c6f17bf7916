"""A step in the ground that no controller knows of: touchdown too early, and too late."""

import time as clock
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from drake_linefoot.lab.results.contact_events import standing, touchdowns
from drake_linefoot.lab.results.judge import judge, upright
from drake_linefoot.lab.results.thresholds import thresholds_of
from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.scenario.disturbances import GroundParameters
from drake_linefoot.lab.simulation.recording import Run
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.sweep.statistics import interval
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from studies.common.runs import stride_time
from studies.common.stamp import Probed
from studies.common.trials import SECONDS

HEIGHT = 0.03  # [m]
SPEEDS = (0.3, 0.6)  # [m/s] of the first walk of a case and of the last
STAND, WALK = 0.5, 4.5  # [s]
FIRST = 0.8  # [m] of the nearest ledge: the walk is steady by then
PHASES = 12  # walks of each case, each with a speed and a place of the ledge in its stride
IMPACT = 0.03  # [s] after a touchdown in which its largest force is taken
DETECTED = 0.05  # [s] after which a touchdown counts as missed
AFTER = 1.0  # [s] after the touchdown in which roll and pitch are taken
CASES = {"up": HEIGHT, "down": -HEIGHT}
GOLDEN = 0.618  # [-] of a stride between the places of two walks
TOUCH = ("impact_n", "latency_ms", "roll_rad", "pitch_rad")
_NEAR = 0.01  # [m] from the new level, with the rolling of the foot


@dataclass(frozen=True)
class Crossing:
    """A walk over a ledge."""

    case: str  # one of `CASES`
    feedback: bool  # whether the gait listened to the contact estimator
    speed: float  # of the walk [m/s]
    at: float  # where the ledge was [m]

    def about(self) -> dict[str, Any]:
        """Return what was walked, as JSON can hold it."""
        about = {"case": self.case, "feedback": self.feedback}
        return {**about, "speed": self.speed, "ledge_at": self.at}

    def scenario(self) -> Scenario:
        """Return what is simulated."""
        base = Scenario()
        walk = Segment("walk", WALK, True, [self.speed, 0.0])
        return replace(
            base,
            name=f"ledge {self.case}",
            segments=[Segment("stand", STAND), walk],
            ground=GroundParameters(ledge_height=CASES[self.case], ledge_at=self.at),
            gait=replace(base.gait, contact_feedback=self.feedback),
        )


def crossings(phases: int = PHASES) -> list[Crossing]:
    """Return the walks of the study: up and down, with feedback and without.

    Speeds are even over `SPEEDS`. The places are even over a stride, but not in the order of the
    speeds.
    """
    stride = stride_time(Scenario())
    speeds = np.linspace(*SPEEDS, phases)
    shares = np.arange(phases) * GOLDEN % 1.0
    return [
        Crossing(case, feedback, float(speed), float(FIRST + share * stride * speed))
        for case in CASES
        for feedback in (True, False)
        for speed, share in zip(speeds, shares, strict=True)
    ]


def first_touch(run: Run, ledge: GroundParameters) -> tuple[int, int] | None:
    """Return foot and sample of the first touchdown beyond a ledge; None without any."""
    at, height = ledge.ledge_at or 0.0, ledge.ledge_height or 0.0
    limits = thresholds_of(run)
    points, loaded = run.contact_points, run.true_normal > limits.load
    beyond = loaded & (points[..., 0] > at) & (np.abs(points[..., 2] - height) < _NEAR)
    found = []
    for foot in (0, 1):
        stands = standing(run.time, run.true_normal[:, foot].sum(axis=1), limits)
        for begin in touchdowns(stands):
            end = int(np.searchsorted(run.time, run.time[begin] + IMPACT))
            if beyond[begin:end, foot].any():
                found.append((int(begin), foot))
                break
    if not found:
        return None
    begin, foot = min(found)
    return foot, begin


def measure(run: Run, ledge: GroundParameters) -> dict[str, Any]:
    """Return what became of a walk over a ledge, as JSON can hold it.

    Returns:
        `upright`, `cause`; and of the first touchdown beyond the ledge, None without any:
        `impact_n`: largest normal force within `IMPACT`, `latency_ms` of its detection, None when
        it was missed, `roll_rad` and `pitch_rad`: largest within `AFTER`.
    """
    outcome = judge(run)
    result: dict[str, Any] = {"upright": upright(outcome), "cause": outcome["cause"]}
    touch = first_touch(run, ledge)
    if touch is None:
        return {**result, **dict.fromkeys(TOUCH)}
    foot, begin = touch
    end, late, after = np.searchsorted(
        run.time, run.time[begin] + np.array([IMPACT, DETECTED, AFTER]) + 1e-9
    )
    raised = np.flatnonzero(run.contact_flag[begin:late, foot] > 0.5)
    latency = 1e3 * float(run.time[begin + raised[0]] - run.time[begin]) if len(raised) else None
    tilt = np.abs(run.rpy[begin:after, :2]).max(axis=0)
    impact = float(run.true_normal[begin:end, foot].sum(axis=1).max())
    values = (impact, latency, *tilt.tolist())
    return {**result, **dict(zip(TOUCH, values, strict=True))}


def cross(crossing: Crossing) -> dict[str, Any]:
    """Simulate a walk over a ledge and measure it."""
    begin, scenario = clock.process_time(), crossing.scenario()
    loop = build_closed_loop(scenario)
    try:
        found = measure(simulate(loop), scenario.ground)
    finally:
        loop.recorder.keep_last(0)
    return {**crossing.about(), **found, SECONDS: round(clock.process_time() - begin, 2)}


def probe() -> dict[str, Probed]:
    """Return a quick form of the study: the first step up, felt and not."""
    found = {}
    for name, feedback in (("felt", True), ("not_felt", False)):
        walks = [one for one in crossings(1) if one.case == "up" and one.feedback == feedback]
        row = cross(walks[0])
        found[f"{name}_upright"] = Probed(float(row["upright"]), 0.0)
        found[f"{name}_impact_n"] = Probed(row["impact_n"] or 0.0, 150.0)
        found[f"{name}_pitch_rad"] = Probed(row["pitch_rad"] or 0.0, 0.03)
    return found


def lost(crossing: Crossing, error: str) -> dict[str, Any]:
    """Return what stands for `cross` of a walk whose process crashed or took too long."""
    return {**crossing.about(), "upright": False, "cause": error, **dict.fromkeys(TOUCH)}


def summarize(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the outcomes of the walks of each case, with and without feedback.

    Returns:
        For each `case` and `feedback`: `n`, `upright`, `low` and `high` of its rate; median and
        largest `impact_n`, `roll_rad`, `pitch_rad`; median `latency_ms`; `missed` touchdowns.
    """
    result = []
    for case in CASES:
        for feedback in (True, False):
            some = [r for r in rows if (r["case"], r["feedback"]) == (case, feedback)]
            if not some:
                continue
            touched = [r for r in some if r["impact_n"] is not None]
            latencies = [r["latency_ms"] for r in touched if r["latency_ms"] is not None]
            good = sum(r["upright"] for r in some)
            low, high = interval(good, len(some))
            figures = {"case": case, "feedback": feedback, "n": len(some), "upright": good}
            figures |= {"low": low, "high": high, "missed": len(touched) - len(latencies)}
            figures["latency_ms"] = float(np.median(latencies)) if latencies else None
            for name in ("impact_n", "roll_rad", "pitch_rad"):
                values = [r[name] for r in touched]
                figures[name] = float(np.median(values)) if values else None
                figures[f"{name}_max"] = max(values, default=None)
            result.append(figures)
    return result
