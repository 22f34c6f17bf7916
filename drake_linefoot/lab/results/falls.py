"""Why a robot fell: what was seen around the beginning of the fall, and what of it came first."""

from dataclasses import dataclass

import numpy as np

from drake_linefoot.lab.results.contact_events import intervals
from drake_linefoot.lab.results.fall_indicators import FallIndicator, fall_indicators
from drake_linefoot.lab.results.thresholds import thresholds_of
from drake_linefoot.lab.simulation.recording import Run

OTHER, UPRIGHT = "other", "upright"

TILT = 0.15  # [rad] of the torso; a steady walk has 0.02, a walk that takes a push 0.12
HEIGHT = 0.9  # [-] of the gait's height of the CoM above the lower foot
STEPS_BEFORE = 2.0  # [-] steps before the onset that are looked at


@dataclass(frozen=True)
class Diagnosis:
    """Why a run fell.

    Attributes:
        cause: one of `CAUSES` of `fall_indicators`, `OTHER`, or `UPRIGHT` without a fall.
        onset: when the fall began [s]; NaN without one.
        indicators: what was seen, the earliest first.
        swings: how the torso swung before the onset, in words.
    """

    cause: str
    onset: float
    indicators: tuple[FallIndicator, ...] = ()
    swings: str = ""

    @property
    def text(self) -> str:
        """All that was seen, each with its time from the onset, separated by commas."""
        seen = [
            f"{s.name} {1e3 * (s.begin - self.onset):+.0f} ms ({s.what})" for s in self.indicators
        ]
        return ", ".join([*seen, self.swings])


def diagnose(run: Run) -> Diagnosis:
    """Tell why a run fell.

    The fall begins (`onset`) when the torso is tilted by more than `TILT`, or the CoM is lower
    than `HEIGHT` of what the gait wants, and never afterwards for a step's time is not. What is
    looked at begins two nominal steps before and ends soon after it (`Thresholds.falling`). The
    cause is the earliest indicator of those that were there in the last step before the onset;
    without any, the earliest of the step before. For what comes later follows from what came
    before: a robot whose foothold is out of reach then slips, stretches its knees, and asks its
    solvers for what no cone allows. And what was over a step earlier was survived. Of indicators
    that begin at once the most severe one counts. A fall without any indicator is `OTHER`.
    """
    if not run.fell:
        return Diagnosis(UPRIGHT, np.nan)
    last = onset_of(run)
    onset = float(run.time[last])
    before = onset - STEPS_BEFORE * _step_time(run) - 1e-9
    after = onset + thresholds_of(run).falling
    first, end = np.searchsorted(run.time, [before, after + 1e-9]).tolist()
    found = fall_indicators(run, first, end)
    near = [s for s in found if s.end >= onset - _step_time(run)] or found
    cause = near[0].name if near else OTHER
    roll, pitch = run.rpy[first:end, 0], run.rpy[first:end, 1]
    swings = f"roll {roll.min():.2f} to {roll.max():.2f} rad"
    swings += f", pitch {pitch.min():.2f} to {pitch.max():.2f} rad"
    return Diagnosis(cause, onset, tuple(found), swings)


def onset_of(run: Run) -> int:
    """Return the last sample before the end at which a fallen robot was still walking.

    It was so for a step's time at least: while it falls it may pass the upright posture again.
    """
    upright = 1.0 - 2.0 * (run.q[:, 1] ** 2 + run.q[:, 2] ** 2)  # cosine of the torso's tilt
    height = run.com[:, 2] - run.contact_points[..., 2].min(axis=(1, 2))
    gait = run.scenario.gait
    fine = intervals((upright > np.cos(TILT)) & (height > HEIGHT * gait.com_height))
    long = [end for begin, end in fine if run.time[end - 1] - run.time[begin] >= _step_time(run)]
    return int(long[-1]) - 1 if long else 0


def _step_time(run: Run) -> float:
    return run.scenario.gait.single_support + run.scenario.gait.double_support
