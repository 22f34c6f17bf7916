"""Processes that carry out jobs, each within a time limit: pebble's pool, for sweeps and studies.

They are forked from a server that has loaded Drake, so that a new one costs little. A job whose
process dies is done again once; one that dies again, or takes too long, has an error in place of
a value, and the other jobs go on.
"""

import gc
import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import forkserver
from types import TracebackType
from typing import Any, Generic, TypeVar

from dask.system import CPU_COUNT
from pebble import ProcessExpired, ProcessPool

from drake_linefoot.errors import LinefootError
from drake_linefoot.lab.simulation.drake_logging import silence_drake

ATTEMPTS = 2  # of a job whose process dies
STARTS = 3  # of the pool, without a job done in between
LIMIT = 3600.0  # [s] of wall time of a job that has no limit of its own
LOOK = 1.0  # [s] between looks at a pool of which nothing is heard
PRELOAD = ["drake_linefoot.lab.wiring.closed_loop", "drake_linefoot.lab.results.judge"]

T = TypeVar("T")
R = TypeVar("R")


@dataclass(frozen=True)
class Done(Generic[T, R]):
    """What became of a job.

    Attributes:
        job: that was given.
        value: that the function returned; None when there is an error.
        error: why there is no value; empty when there is one.
        attempts: times it was begun.
    """

    job: T
    value: R | None
    error: str = ""
    attempts: int = 1


class Pool:
    """Processes on this machine, inside a `with` block; none is left at its end."""

    def __init__(
        self, processes: int | None = None, recycle: int = 0, most: int | None = None
    ) -> None:
        """Make a pool.

        Args:
            processes: that work at a time; None for one per processor.
            recycle: jobs after which a process is replaced, so that its memory stays bounded;
                0 for never.
            most: jobs that there will be; more processes are not started.
        """
        self._processes, self._recycle = processes or CPU_COUNT, recycle
        if most is not None:
            self._processes = min(self._processes, most)

    def __enter__(self) -> "Pool":
        """Start the server that processes are forked from."""
        self._context = multiprocessing.get_context("forkserver")
        self._context.set_forkserver_preload(PRELOAD)
        with _uninterrupted():
            forkserver.ensure_running()
        self._start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End the processes, whatever they do."""
        self._stop()

    def _start(self) -> None:
        self._pool = ProcessPool(
            self._processes, self._recycle, initializer=_begin_work, context=self._context
        )

    def _stop(self) -> None:
        self._pool.stop()
        self._pool.join()

    def run(
        self,
        function: Callable[[T], R],
        jobs: Iterable[T],
        limit: Callable[[T], float] = lambda job: LIMIT,
        report: Callable[[T, str], None] = lambda job, what: None,
    ) -> Iterator[Done[T, R]]:
        """Carry out jobs; yields what became of each, the first that is done first.

        Args:
            function: of a module, so that a process can import it.
            jobs: its arguments.
            limit: of each job [s] of wall time.
            report: called with a job that is done again, and why.

        Raises:
            LinefootError: processes die before they take a job, again and again.
            Exception: what the function raised.
        """
        waiting = deque((job, 1) for job in jobs)
        running: dict[Future[R], tuple[T, int]] = {}
        starts = 1
        while waiting or running:
            try:
                while waiting and len(running) < 2 * self._processes:
                    job, attempt = waiting[0]
                    future: Future[R] = self._pool.schedule(function, (job,), timeout=limit(job))
                    running[future] = waiting.popleft()
                finished = list(wait(running, LOOK, return_when=FIRST_COMPLETED).done)
                if not (finished or self._pool.active):  # it broke before it took the last jobs
                    starts = self._again(starts, waiting, running)
            except RuntimeError:  # the pool broke since the last look at it
                finished = []
                starts = self._again(starts, waiting, running)
            for future in finished:
                error = future.exception()
                if isinstance(error, BrokenProcessPool):
                    starts = self._again(starts, waiting, running)
                    break
                job, attempt = running.pop(future)
                starts = 1
                if isinstance(error, ProcessExpired) and attempt < ATTEMPTS:
                    report(job, death(error.exitcode or 0))
                    waiting.appendleft((job, attempt + 1))
                elif isinstance(error, ProcessExpired):
                    yield Done(job, None, f"{death(error.exitcode or 0)}, {attempt} times", attempt)
                elif isinstance(error, TimeoutError):
                    yield Done(job, None, too_long(limit(job)), attempt)
                elif isinstance(error, MemoryError):
                    yield Done(job, None, "its worker ran out of memory", attempt)
                else:
                    yield Done(job, future.result(), attempts=attempt)

    def _again(self, starts: int, waiting: deque[Any], running: dict[Any, Any]) -> int:
        """Start anew with the jobs that were not done: a process died that had none."""
        if starts == STARTS:
            raise LinefootError("the worker processes die before they take a job")
        waiting.extendleft(reversed(running.values()))
        running.clear()
        self._stop()
        self._start()
        return starts + 1


def death(code: int) -> str:
    """Return in words how a process ended: for lack of memory the system kills it by SIGKILL."""
    how = f"was killed by {signal.Signals(-code).name}" if code < 0 else f"ended with status {code}"
    return f"its worker {how}"


def too_long(limit: float) -> str:
    """Return in words that a job took longer than its limit [s]."""
    return f"took longer than its limit of {limit:.0f} s"


@contextmanager
def _uninterrupted() -> Iterator[None]:
    """Ignore Ctrl-C inside, and in the processes that are started inside, also while they load."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _begin_work() -> None:
    """Be quiet, die at once when told to, and with the process that started this one."""
    silence_drake()
    gc.freeze()  # to look through what is imported takes longer than a short job
    signal.signal(signal.SIGTERM, signal.SIG_DFL)  # a handler would wait for compiled code
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
