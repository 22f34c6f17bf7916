"""Handing runs to the workers of a cluster, one at a time each.

Every run is bound to one worker. So it is known which run a worker had that died, whatever the
settings of the scheduler; the run is done again once, by another, and counted. Dask would hand it
to another worker as well, but as often as its scheduler is set to, and without saying so.
"""

import time as clock
import warnings
from collections import Counter, deque
from collections.abc import Callable, Iterable
from concurrent.futures import CancelledError
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from distributed import Client, Future, wait
from distributed.scheduler import KilledWorker
from tornado.iostream import StreamClosedError

from drake_linefoot.errors import LinefootError
from drake_linefoot.lab.sweep.jobs import Job
from drake_linefoot.lab.sweep.provenance import differences, made_with
from drake_linefoot.lab.sweep.rows import FAILED, Row, row_of
from drake_linefoot.lab.sweep.worker import carry_out, leave

ATTEMPTS = 2  # of a run whose worker dies
POLL = 0.2  # [s] between two looks at the workers
GATHERING = 5.0  # [s] that a worker has to send a row
PATIENCE = 120.0  # [s] without any worker


@dataclass
class _Task:
    """A run that a worker has."""

    job: Job
    attempt: int
    future: Future[Any]
    since: float  # when it was handed out [s]


class Dispatcher:
    """Has runs carried out by the workers of a cluster."""

    def __init__(
        self,
        client: Client,
        record: Callable[[Row], None],
        report: Callable[[str], None],
        recycle: int | None = None,
    ) -> None:
        """Use the workers of `client`.

        Args:
            client: of the cluster.
            record: called with every row.
            report: called with what happens to workers, in words.
            recycle: number of runs after which a worker is replaced by a new process, so that
                its memory stays bounded; None leaves the workers alone.
        """
        self._client, self._recycle = client, recycle
        self._record, self._report = record, report
        self._waiting: deque[tuple[Job, int]] = deque()
        self._busy: dict[str, _Task] = {}
        self._done: Counter[str] = Counter()  # runs by worker
        self._leaving: set[str] = set()  # workers that are about to end

    def run(self, jobs: Iterable[Job]) -> None:
        """Carry out all runs.

        Raises:
            LinefootError: the scheduler is lost, there are no workers, or they have other code.
        """
        self._waiting.extend((job, 1) for job in jobs)
        try:
            self._run()
        except KeyboardInterrupt:  # what the client has begun it drops when it closes
            warnings.filterwarnings("ignore", "coroutine .* was never awaited", RuntimeWarning)
            raise
        except (OSError, CancelledError, StreamClosedError) as error:
            if isinstance(error, LinefootError):
                raise
            problem = f"the scheduler of the cluster is lost: {type(error).__name__}"
            raise LinefootError(problem) from error

    def _run(self) -> None:
        with self._client.as_current():
            while self._waiting or self._busy:
                alive = self._workers()
                for address, task in list(self._busy.items()):
                    if task.future.done():
                        self._collect(address, task)
                    elif address not in alive:
                        self._redo(address, task)
                self._hand_out(alive)
                futures = [task.future for task in self._busy.values()]
                with suppress(TimeoutError):
                    if futures:
                        wait(futures, timeout=POLL, return_when="FIRST_COMPLETED")
                    else:
                        clock.sleep(POLL)

    def _workers(self) -> set[str]:
        """Return the addresses of the workers there are; wait for the first one."""
        try:
            if not self._client.nthreads():
                self._client.wait_for_workers(1, timeout=PATIENCE)
            return set(self._client.nthreads())
        except TimeoutError as error:
            problem = f"the cluster has no worker, or its scheduler does not answer: {error}"
            raise LinefootError(problem) from error

    def _redo(self, address: str, task: _Task) -> None:
        """Do the run of a worker that died again, or give it up."""
        self._busy.pop(address)
        task.future.cancel()
        job, attempt = task.job, task.attempt
        name = f"run {job.index} of {job.group}"
        if clock.monotonic() - task.since >= job.limit:
            self._report(f"{name} is given up after {job.limit:.0f} s")
            error = f"took longer than its limit of {job.limit:.0f} s"
        elif attempt < ATTEMPTS:
            self._report(f"worker {address} died; {name} is done again")
            self._waiting.appendleft((job, attempt + 1))
            return
        else:
            self._report(f"worker {address} died; {name} is given up after {attempt} attempts")
            error = f"its worker died, {attempt} times"
        work = {"error": error, "attempts": attempt, "worker": address}
        self._record(row_of(job, FAILED, work))

    def _collect(self, address: str, task: _Task) -> None:
        """Take the result of a run that is done."""
        try:
            row, theirs = task.future.result(timeout=GATHERING)
        except TimeoutError:  # its worker died with the row, or is slow: looked at again
            return
        except KilledWorker:
            self._redo(address, task)
            return
        except Exception as error:
            raise LinefootError(f"worker {address}: {error}") from error
        changed = differences(made_with(), theirs)
        if changed:
            raise LinefootError(f"worker {address} has {changed}")
        self._busy.pop(address)
        self._done[address] += 1
        self._record({**row, "attempts": task.attempt, "worker": address})

    def _hand_out(self, alive: set[str]) -> None:
        """Give each idle worker a run."""
        self._leaving &= alive
        for address in sorted(alive - self._leaving - set(self._busy)):
            if not self._waiting:
                return
            if self._recycle is not None and self._done[address] >= self._recycle:
                self._replace(address)
                continue
            job, attempt = self._waiting.popleft()
            future = self._client.submit(
                carry_out, job, workers=[address], allow_other_workers=False, pure=False
            )
            self._busy[address] = _Task(job, attempt, future, clock.monotonic())

    def _replace(self, address: str) -> None:
        """Have an idle worker end; what started it starts a new one.

        Not by dask's `restart_workers`: now and then that takes the new one for the old one, and
        ends it as well.
        """
        self._done.pop(address)
        self._leaving.add(address)
        self._client.run(leave, workers=[address], wait=False)
