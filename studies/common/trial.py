"""One walk with one command, judged: what the grid, the tuning and the envelope are made of."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.lab.results.metrics import segment_velocity
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.scenario.edit import with_command, with_duration
from drake_linefoot.lab.scenario.load import parse_scenario
from drake_linefoot.lab.simulation.recording import Run
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from studies.common import runs

STAND = 0.5  # [s] before the walk
AT_LIMIT = 0.99  # [-] of a torque's limit
OFTEN = 0.01  # [-] of the ticks in which torques are at their limits, or cut, to be named


def walk(scenario: Scenario, command: Sequence[float], duration: float) -> Scenario:
    """Return a scenario that stands for `STAND` and then walks with one command.

    The command is forward, left [m/s] and turn rate [rad/s]; `duration` [s] is of all of it.
    """
    vx, vy, turn = map(float, command)
    return with_duration(with_command(scenario, vx, vy, turn, STAND), duration)


def judge(run: Run) -> dict[str, Any]:
    """Return how upright a walk of `walk` was, and how well it followed its command.

    Returns:
        `fell`, `fall_time`, `fall_reason`; from the first step on `roll_rms`, `pitch_rms`,
        `roll_max`, `pitch_max` [rad], `torque_limited`: in which share of the ticks any torque was
        at its limit, and `at_limit`: by joint, see `often_at_limit`; over the second half of the
        walk, in whole strides, `measured`: forward, left, turn rate, and `speed_error`: of the
        first two [m/s]. What a fall leaves without a value is None.
    """
    w = runs.walking(run)
    command = run.scenario.segments[-1]
    measured = segment_velocity(run, STAND, run.scenario.duration)
    error = None
    if measured is not None:
        error = float(np.linalg.norm(measured[:2] - np.array(command.velocity)))
    result: dict[str, Any] = {
        "fell": run.fell,
        "fall_time": run.fall_time,
        "fall_reason": run.fall_reason,
        "measured": None if measured is None else measured.tolist(),
        "speed_error": error,
    }
    for i, name in enumerate(("roll", "pitch")):
        angle = run.rpy[w, i]
        result[f"{name}_rms"] = runs.jsonable(runs.rms(angle))
        result[f"{name}_max"] = float(np.abs(angle).max()) if angle.size else None
    limited = np.abs(run.torque[w]) >= AT_LIMIT * run.effort_limits
    result["torque_limited"] = float(limited.any(axis=1).mean()) if len(limited) else None
    return {**result, "at_limit": often_at_limit(run.joint_names, limited)}


def often_at_limit(joints: Sequence[str], limited: NDArray[np.bool_]) -> dict[str, float]:
    """Return in which share of a walk torques were at their limits, by joint, the largest first.

    `limited` says so of each tick, shape (n, na). A share below `OFTEN` is left out.
    """
    shares = limited.mean(axis=0).tolist() if len(limited) else []
    found = sorted(zip(joints, shares, strict=False), key=lambda one: -one[1])
    return {joint: share for joint, share in found if share >= OFTEN}


def tried(job: tuple[Any, str]) -> dict[str, Any]:
    """Simulate and judge a scenario (YAML text); returns `judge` with the `label` before it."""
    label, text = job
    return {"label": label, **judge(simulate(build_closed_loop(parse_scenario(text))))}
