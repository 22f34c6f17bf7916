"""What a worker process does: simulates a run and judges it.

As a script it carries out one run, which it reads from stdin.
"""

import gc
import os
import pickle
import socket
import sys
import time as clock
from typing import Any

import psutil

from drake_linefoot.lab.results.judge import judge
from drake_linefoot.lab.results.provenance import made_with
from drake_linefoot.lab.scenario.load import parse_scenario
from drake_linefoot.lab.simulation.drake_logging import silence_drake
from drake_linefoot.lab.simulation.recording import Run
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.sweep.jobs import Job
from drake_linefoot.lab.sweep.rows import FAILED, Made, row_of
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop


def carry_out(job: Job) -> Made:
    """Simulate and judge a run.

    Returns:
        Its row, and what it was made with. An error is a row, too.
    """
    silence_drake()
    start = clock.perf_counter()
    work: dict[str, Any] = {"worker": f"{socket.gethostname()}:{os.getpid()}"}
    try:
        outcome = judge(simulated(job.scenario))
    except (Exception, SystemExit) as problem:  # Drake's own assertions are a SystemExit
        outcome = FAILED
        work["error"] = f"{type(problem).__name__}: {' '.join(str(problem).split())}"
    work["wall_seconds"] = clock.perf_counter() - start
    gc.collect()  # what Drake holds is not seen by the collector until it looks
    work["worker_mb"] = psutil.Process().memory_info().rss / 1e6
    return row_of(job, outcome, work), made_with()


def simulated(scenario: str) -> Run:
    """Simulate a scenario (YAML text)."""
    loop = build_closed_loop(parse_scenario(scenario))
    try:
        return simulate(loop)
    finally:
        # On CPython 3.11 a LeafSystem written in Python is never freed; its samples are.
        loop.recorder.keep_last(0)


if __name__ == "__main__":
    answer = os.dup(sys.stdout.fileno())
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # whatever a library prints is no answer
    with os.fdopen(answer, "wb") as file:
        pickle.dump(carry_out(pickle.load(sys.stdin.buffer)), file)
