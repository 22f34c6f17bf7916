"""One walk with one command, judged: what the grid, the tuning and the envelope are made of."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.lab.results.gait_figures import at_limit
from drake_linefoot.lab.results.judge import OUTCOME, judge, upright
from drake_linefoot.lab.results.metrics import segment_velocity
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.scenario.edit import with_command, with_duration
from drake_linefoot.lab.scenario.load import parse_scenario
from drake_linefoot.lab.simulation.recording import Run
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from studies.common import runs

STAND = 0.5  # [s] before the walk
OFTEN = 0.01  # [-] of the ticks in which torques are at their limits, or cut, to be named
LATER = ("measured", "roll_rms", "pitch_rms", "torque_limited")


def walk(scenario: Scenario, command: Sequence[float], duration: float) -> Scenario:
    """Return a scenario that stands for `STAND` and then walks with one command.

    The command is forward, left [m/s] and turn rate [rad/s]; `duration` [s] is of all of it.
    """
    vx, vy, turn = map(float, command)
    return with_duration(with_command(scenario, vx, vy, turn, STAND), duration)


def outcome_of(scenario: Scenario) -> dict[str, Any]:
    """Simulate a scenario; return what `judge` says of it."""
    loop = build_closed_loop(scenario)
    outcome = judge(simulate(loop))
    loop.recorder.keep_last(0)
    return outcome


def judge_walk(run: Run) -> dict[str, Any]:
    """Return the outcome of a walk of `walk`, and how well it followed its command.

    Returns:
        What `judge` says, and `upright`; over the second half of the walk, in whole strides,
        `measured`: forward, left [m/s], turn rate [rad/s]; from the first step on `roll_rms`,
        `pitch_rms` [rad], `torque_limited`: in which share of the ticks any torque was at its
        limit, and `at_limit`: by joint, see `often_at_limit`. What a fall leaves without a value
        is None.
    """
    w, outcome = runs.walking(run), judge(run)
    measured = segment_velocity(run, STAND, run.scenario.duration)
    limited = at_limit(run)[w]
    return {
        **outcome,
        "upright": upright(outcome),
        "measured": None if measured is None else measured.tolist(),
        "roll_rms": runs.jsonable(runs.rms(run.rpy[w, 0])),
        "pitch_rms": runs.jsonable(runs.rms(run.rpy[w, 1])),
        "torque_limited": float(limited.any(axis=1).mean()) if len(limited) else None,
        "at_limit": often_at_limit(run.joint_names, limited),
    }


def lost_walk(error: str) -> dict[str, Any]:
    """Return what stands for `judge_walk` of a walk whose process crashed or took too long."""
    fallen = {"fell": True, "fall_time": 0.0, "fall_reason": error, "cause": "error"}
    rest: dict[str, Any] = {"upright": False, "at_limit": {}, **dict.fromkeys(LATER)}
    return {**dict.fromkeys(OUTCOME), **fallen, **rest}


def often_at_limit(joints: Sequence[str], limited: NDArray[np.bool_]) -> dict[str, float]:
    """Return in which share of a walk torques were at their limits, by joint, the largest first.

    `limited` says so of each tick, shape (n, na). A share below `OFTEN` is left out.
    """
    shares = limited.mean(axis=0).tolist() if len(limited) else []
    found = sorted(zip(joints, shares, strict=False), key=lambda one: -one[1])
    return {joint: share for joint, share in found if share >= OFTEN}


def tried(job: tuple[Any, str]) -> dict[str, Any]:
    """Simulate and judge a scenario (YAML text); returns `label` and `judge_walk`."""
    label, text = job
    loop = build_closed_loop(parse_scenario(text))
    row = judge_walk(simulate(loop))
    loop.recorder.keep_last(0)  # Python 3.11 does not free a loop, so its recording would stay
    return {"label": label, **row}


def lost(job: tuple[Any, str], error: str) -> dict[str, Any]:
    """Return what stands for `tried`, see `lost_walk`."""
    return {"label": job[0], **lost_walk(error)}
