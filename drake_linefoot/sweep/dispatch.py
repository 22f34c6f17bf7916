"""Handing runs to the workers of a cluster, one at a time each.

Every run is bound to one worker. So it is known which run a worker had that died, whatever the
settings of the scheduler; the run is done again once, by another, and counted.
"""

from __future__ import annotations

import time as clock
from collections import Counter, deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from drake_linefoot.errors import LinefootError
from drake_linefoot.sweep.jobs import Job
from drake_linefoot.sweep.provenance import differences, made_with
from drake_linefoot.sweep.rows import Row, failed_row
from drake_linefoot.sweep.worker import carry_out, leave

if TYPE_CHECKING:
    from distributed import Client, Future

ATTEMPTS = 2  # of a run whose worker dies
POLL = 0.2  # [s] between two looks at the workers
PATIENCE = 120.0  # [s] without any worker


@dataclass
class _Task:
    """A run that a worker has."""

    job: Job
    attempt: int
    future: Future[Any]


class Dispatcher:
    """Has runs carried out by the workers of a cluster."""

    def __init__(
        self,
        client: Client,
        hear: Callable[[Row], None],
        tell: Callable[[str], None],
        recycle: int | None = None,
    ) -> None:
        """Use the workers of `client`.

        Args:
            client: of the cluster.
            hear: called with every row.
            tell: called with what is to be reported, in words.
            recycle: number of runs after which a worker is replaced by a new process, so that
                its memory stays bounded; None leaves the workers alone.
        """
        self._client = client
        self._hear, self._tell = hear, tell
        self._recycle = recycle
        self._waiting: deque[tuple[Job, int]] = deque()
        self._busy: dict[str, _Task] = {}
        self._done: Counter[str] = Counter()  # runs by worker
        self._leaving: set[str] = set()  # workers that were told to end

    def run(self, jobs: Iterable[Job]) -> None:
        """Carry out all runs.

        Raises:
            LinefootError: the scheduler is lost, there are no workers, or they have other code.
        """
        self._waiting.extend((job, 1) for job in jobs)
        with self._client.as_current():
            self._run()

    def _run(self) -> None:
        seen = clock.monotonic()
        while self._waiting or self._busy:
            alive = self._workers()
            self._take_back(alive)
            self._collect()
            self._hand_out(alive)
            if alive:
                seen = clock.monotonic()
            elif clock.monotonic() - seen > PATIENCE:
                raise LinefootError(f"the cluster has had no worker for {PATIENCE:.0f} s")
            self._wait()

    def _workers(self) -> set[str]:
        """Return the addresses of the workers there are."""
        try:
            return set(self._client.nthreads())
        except (OSError, TimeoutError) as error:
            raise LinefootError(f"the scheduler does not answer: {error}") from error

    def _take_back(self, alive: set[str]) -> None:
        """Take back the runs of workers that are gone."""
        for address in [address for address in self._busy if address not in alive]:
            if not self._busy[address].future.done():
                self._died(address)

    def _died(self, address: str) -> None:
        """Do the run of a worker that died again, or give it up."""
        task = self._busy.pop(address)
        task.future.cancel()
        name = f"run {task.job.index} of {task.job.group}"
        if task.attempt < ATTEMPTS:
            self._tell(f"worker {address} died; {name} is done again")
            self._waiting.appendleft((task.job, task.attempt + 1))
            return
        self._tell(f"worker {address} died; {name} is given up after {task.attempt} attempts")
        error = f"its worker died, {task.attempt} times"
        work = {"attempts": task.attempt, "worker": address}
        self._hear(failed_row(task.job, error, work))

    def _collect(self) -> None:
        """Take the results of what is done."""
        from distributed.scheduler import KilledWorker

        for address, task in list(self._busy.items()):
            if not task.future.done():
                continue
            try:
                row, theirs = task.future.result()
            except KilledWorker:
                self._died(address)
                continue
            except Exception as error:
                raise LinefootError(f"worker {address}: {error}") from error
            changed = differences(made_with(), theirs)
            if changed:
                raise LinefootError(f"worker {address} has {changed}")
            self._busy.pop(address)
            self._done[address] += 1
            self._hear({**row, "attempts": task.attempt, "worker": address})

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
            self._busy[address] = _Task(job, attempt, future)

    def _replace(self, address: str) -> None:
        """Have an idle worker end; what started it starts a new one.

        Not by dask's `restart_workers`: now and then that takes the new one for the old one, and
        ends it as well.
        """
        self._done.pop(address)
        self._leaving.add(address)
        self._client.run(leave, workers=[address], wait=False)

    def _wait(self) -> None:
        """Wait for a result, but not for long."""
        from distributed import wait

        futures = [task.future for task in self._busy.values()]
        if not futures:
            clock.sleep(POLL)
            return
        try:
            wait(futures, timeout=POLL, return_when="FIRST_COMPLETED")
        except TimeoutError:
            return
