"""One trial: simulated, judged, and what came of it as plain data."""

from typing import Any

import numpy as np

from drake_linefoot.lab.results.gait_figures import flight_times
from drake_linefoot.lab.results.judge import judge, upright
from drake_linefoot.lab.results.metrics import compute_metrics
from drake_linefoot.lab.simulation.recording import Run
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from studies.common.types import Data
from studies.running.cases import PICTURE, STAND, Trial, scenario

GO = 1  # segment that is measured
STILL = 0.05  # [m/s] of the torso of a robot that stands
SHOWN, STRIDE = 1.5, 2  # [s] of the end of the run that is drawn, ticks between its points


def tried(trial: Trial) -> Data:
    """Simulate and judge a trial.

    Returns:
        `key`, `case`, `label`, `index`; `upright`, `reason` why it was not; of the second half of
        what it was told to do `measured`: forward, left [m/s], turn rate [rad/s], None after a
        fall, and `gait`, see `gait_figures`; `tilt`: largest of roll and pitch then [rad], and
        `turns`: between which the torso yaws [rad]; `stands`: whether it stands still on both feet
        at the end; `push`: direction [rad] and time after the first one [s]; `state_hash`; of the
        run that is drawn `curves`.
    """
    loop = build_closed_loop(scenario(trial))
    run = simulate(loop)
    outcome = judge(run)
    row = {**named(trial), **_found(run), "upright": upright(outcome)}
    row["reason"] = "" if row["upright"] else outcome["fall_reason"] or outcome["cause"]
    row["state_hash"] = outcome["state_hash"]
    if trial.case == PICTURE:
        row["curves"] = curves(run)
    loop.recorder.keep_last(0)
    return row


def lost(trial: Trial, error: str) -> Data:
    """Return what stands for `tried` of a trial whose process crashed or took too long."""
    nothing = dict.fromkeys(("measured", "gait", "tilt", "turns", "push", "state_hash"))
    return {**named(trial), **nothing, "stands": False, "upright": False, "reason": error}


def named(trial: Trial) -> Data:
    """Return which trial a row is of."""
    return {
        "key": trial.key,
        "case": trial.case,
        "label": trial.label,
        "index": trial.index,
    }


def _found(run: Run) -> Data:
    segment = compute_metrics(run)["segments"][GO if len(run.scenario.segments) > 1 else 0]
    end = STAND + (run.scenario.segments[GO].duration if len(run.scenario.segments) > 1 else 0.0)
    later = (run.time >= 0.5 * (STAND + end)) & (run.time <= end)
    still = float(np.linalg.norm(run.v[-1, 3:6])) < STILL
    push = run.scenario.pushes[0] if run.scenario.pushes else None
    return {
        "measured": segment["measured"],
        "gait": segment["gait"],
        "tilt": float(np.abs(run.rpy[later, :2]).max()) if later.any() else None,
        "turns": float(np.ptp(np.unwrap(run.rpy[later, 2]))) if later.any() else None,
        "stands": not run.fell and still and bool(run.planned_contact[-1].all()),
        "push": None if push is None else [push.direction, push.time],
    }


def curves(run: Run) -> dict[str, Any]:
    """Return what the picture of a run shows of its last `SHOWN` seconds."""
    some = np.flatnonzero(run.time >= run.time[-1] - SHOWN)[::STRIDE]
    air = flight_times(run)
    return {
        "time": run.time[some].tolist(),
        "force": run.true_force[some, :, 2].tolist(),
        "height": run.com[some, 2].tolist(),
        "speed": np.linalg.norm(np.gradient(run.com[:, :2], run.time, axis=0), axis=1)[
            some
        ].tolist(),
        "flights": air[air[:, 1] > run.time[some[0]]].tolist(),
    }
