"""Runs on a cluster of dask.distributed that exists: each in a process of its own.

So a run that hangs or crashes ends neither a worker nor the runs of others.
"""

import logging
import os
import pickle
import subprocess
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import contextmanager

from distributed import Client, as_completed
from distributed.scheduler import KilledWorker

from drake_linefoot.errors import InputError, LinefootError
from drake_linefoot.lab.pool import ATTEMPTS, Done, death, too_long
from drake_linefoot.lab.sweep.jobs import Job
from drake_linefoot.lab.sweep.rows import Made

ANSWER = 10.0  # [s] within which a scheduler must answer
WORKER = "drake_linefoot.lab.sweep.worker"  # the script of one run
PATIENCE = 120.0  # [s] without any worker


@contextmanager
def existing_cluster(address: str) -> Iterator[Client]:
    """Connect to a cluster by the address of its scheduler; gives a client of it.

    Its workers must have the same drake_linefoot installed.

    Raises:
        InputError: no scheduler answers there.
        LinefootError: it has no worker.
    """
    for name in ("distributed", "distributed.client"):  # which has a level of its own
        logging.getLogger(name).setLevel(logging.CRITICAL)
    try:
        client = Client(address, timeout=ANSWER, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        allowed = f"no scheduler of dask.distributed answers there: {reason}"
        raise InputError("--scheduler", "", address, allowed) from error
    with client:
        try:
            client.wait_for_workers(1, timeout=PATIENCE)
        except TimeoutError as error:
            raise LinefootError("the cluster has no worker") from error
        yield client


def run_on_cluster(client: Client, jobs: Sequence[Job]) -> Iterator[Done[Job, Made]]:
    """Carry out runs; yields what became of each, as `Pool.run`.

    Raises:
        LinefootError: the scheduler is lost.
    """
    waiting = dict(zip(client.map(carry_out_apart, jobs, pure=False), jobs, strict=True))
    for future in as_completed(waiting, loop=client.loop):
        job = waiting.pop(future)
        try:
            yield future.result()
        except KilledWorker as error:
            yield Done(job, None, f"its worker died: {error}", ATTEMPTS)
        except (OSError, CancelledError) as error:
            problem = f"the scheduler of the cluster is lost: {type(error).__name__}"
            raise LinefootError(problem) from error


def carry_out_apart(job: Job) -> Done[Job, Made]:
    """Carry out a run in a new process; a second time when that dies."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    code = 0
    for attempt in range(1, ATTEMPTS + 1):
        try:
            done = subprocess.run(
                [sys.executable, "-m", WORKER],
                input=pickle.dumps(job),
                stdout=subprocess.PIPE,
                timeout=job.limit,
                env=environment,
                check=False,
            )
        except subprocess.TimeoutExpired:
            return Done(job, None, too_long(job.limit), attempt)
        if (code := done.returncode) == 0:
            return Done(job, pickle.loads(done.stdout), attempts=attempt)
    return Done(job, None, f"{death(code)}, {ATTEMPTS} times", ATTEMPTS)
