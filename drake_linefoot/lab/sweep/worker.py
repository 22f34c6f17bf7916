"""What a worker process does: carries out one run after the other.

A process of the cluster loads this module first (`dask_setup`), which limits BLAS to one thread
and leaves Ctrl-C to the process that dispatches the runs.
"""

import asyncio
import faulthandler
import gc
import os
import signal
import time as clock
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import psutil

from drake_linefoot.lab.scenario.load import parse_scenario
from drake_linefoot.lab.simulation.quiet import quieten_drake
from drake_linefoot.lab.simulation.recording import Run
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.sweep.jobs import Job
from drake_linefoot.lab.sweep.provenance import made_with
from drake_linefoot.lab.sweep.rows import FAILED, Row, outcome, row_of
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop

ANSWER = 0.05  # [s] that an answer may take to leave


def dask_setup(_worker: object) -> None:
    """Leave Ctrl-C to the process that started the cluster; called in the main thread.

    What is imported by now stays: to look through it after each run takes longer than short runs.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    gc.freeze()


def carry_out(job: Job) -> tuple[Row, dict[str, str]]:
    """Simulate and judge a run.

    Returns:
        Its row, and what it was made with. An error is a row, too: whatever one run does, the
        others go on. A run that hangs ends this process, see `within`.
    """
    quieten_drake()
    start = clock.perf_counter()
    work: dict[str, Any] = {}
    try:
        with within(job.limit):
            came_to = outcome(simulated(job.scenario))
    except (Exception, SystemExit) as problem:  # Drake's own assertions are a SystemExit
        came_to = FAILED
        work["error"] = f"{type(problem).__name__}: {' '.join(str(problem).split())}"
    work["wall_seconds"] = clock.perf_counter() - start
    gc.collect()  # what Drake holds is not seen by the collector until it looks
    work["worker_mb"] = psutil.Process().memory_info().rss / 1e6
    return row_of(job, came_to, work), made_with()


@contextmanager
def within(seconds: float) -> Iterator[None]:
    """End this process when the `with` block takes longer.

    Nothing gentler ends a loop in Drake or in compiled code, which lets no other thread run.
    """
    with open(os.devnull, "w") as nowhere:
        faulthandler.dump_traceback_later(seconds, exit=True, file=nowhere)
        try:
            yield
        finally:
            faulthandler.cancel_dump_traceback_later()


async def leave() -> None:
    """End this process, which has nothing to do, once it has answered."""
    await asyncio.sleep(ANSWER)
    os._exit(0)


def simulated(scenario: str) -> Run:
    """Simulate a scenario (YAML text)."""
    loop = build_closed_loop(parse_scenario(scenario))
    try:
        return simulate(loop)
    finally:
        # On CPython 3.11 a LeafSystem written in Python is never freed; its samples are.
        loop.recorder.keep_last(0)
