"""One walk with one command, judged: what the grid, the tuning and the envelope are made of."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from drake_linefoot.errors import LinefootError
from drake_linefoot.evaluation import runs
from drake_linefoot.scenario import Scenario, Segment
from drake_linefoot.scenario_io import parse_scenario
from drake_linefoot.simulation.metrics import segment_velocity
from drake_linefoot.simulation.quiet import quieten_drake
from drake_linefoot.simulation.recording import Run
from drake_linefoot.simulation.run import simulate
from drake_linefoot.wiring.closed_loop import ClosedLoop, build_closed_loop

PROCESSES = 2
STAND = 0.5  # [s] before the walk


@dataclass(frozen=True)
class Job:
    """A walk to simulate.

    Attributes:
        label: of whoever asks, as JSON can hold it.
        scenario: YAML text.
    """

    label: Any
    scenario: str


def walk(scenario: Scenario, command: Sequence[float], duration: float) -> Scenario:
    """Return a scenario that stands for `STAND` and then walks with one command.

    Args:
        scenario: everything else.
        command: forward, left [m/s], turn rate [rad/s].
        duration: of all of it [s].
    """
    vx, vy, turn = (float(value) for value in command)
    segments = [
        Segment("stand", STAND),
        Segment("walk", duration - STAND, walk=True, velocity=[vx, vy], turn_rate=turn),
    ]
    return replace(scenario, segments=segments)


def judge(run: Run) -> dict[str, Any]:
    """Return how upright a walk of `walk` was, and how well it followed its command.

    Returns:
        `fell`, `fall_time`, `fall_reason`; from the first step on `roll_rms`, `pitch_rms`,
        `roll_max`, `pitch_max` [rad]; over the second half of the walk, in whole strides,
        `measured`: forward, left, turn rate, and `speed_error`: of the first two [m/s]. What a
        fall leaves without a value is None.
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
    return result


def simulated(what: Scenario | ClosedLoop) -> Run:
    """Simulate a scenario, or a loop, without a word."""
    quieten_drake()
    return simulate(build_closed_loop(what) if isinstance(what, Scenario) else what)


def carry_out(job: Job) -> dict[str, Any]:
    """Simulate and judge a job; returns `judge` with its `label`."""
    return {"label": job.label, **judge(simulated(parse_scenario(job.scenario)))}


@contextmanager
def workers(processes: int = PROCESSES) -> Iterator[ProcessPoolExecutor]:
    """Give processes that carry out jobs; none is left when this ends, however it ends.

    Raises:
        LinefootError: a process died under its job, for instance for lack of memory.
    """
    context = multiprocessing.get_context("spawn")
    before = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(processes, context, _begin_work)
    try:
        yield pool
    except BaseException as error:
        for process in set(multiprocessing.active_children()) - before:
            process.terminate()  # nobody waits for what it does
        if isinstance(error, BrokenProcessPool):
            raise LinefootError("a worker process died; its run has no result") from error
        raise
    finally:
        pool.shutdown(cancel_futures=True)


def _begin_work() -> None:
    """Leave Ctrl-C to the process that started this one, and end when that ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
