"""The processes that carry out the work of every study."""

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from drake_linefoot.errors import LinefootError
from drake_linefoot.lab.simulation.quiet import quieten_drake

PROCESSES = 2

_words: Any = None  # in a worker: the queue to the process that started it


@contextmanager
def workers(
    processes: int = PROCESSES, report: Callable[..., None] | None = None
) -> Iterator[ProcessPoolExecutor]:
    """Give processes that carry out jobs; none is left when this ends, however it ends.

    Args:
        processes: that work at a time.
        report: called, in a thread, with what jobs `say`.

    Raises:
        LinefootError: a process died under its job, for instance for lack of memory.
    """
    context = multiprocessing.get_context("spawn")
    before = set(multiprocessing.active_children())
    words = context.Queue()
    listener = threading.Thread(target=_listen, args=(words, report), daemon=True)
    listener.start()
    pool = ProcessPoolExecutor(processes, context, _begin_work, (words,))
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
        words.put(None)
        listener.join()


def carry_out(
    function: Callable[[Any], Any],
    jobs: Sequence[Any],
    done: Callable[[float, str], None],
    processes: int = PROCESSES,
) -> list[Any]:
    """Return what a function gives for each job, in their order.

    It is of a module, so that a process can import it. `done` is called after each job with the
    share of them that is done, and in words.

    Raises:
        LinefootError: a process died.
    """
    results = []
    with workers(processes) as pool:
        for result in pool.map(function, jobs):
            results.append(result)
            done(len(results) / len(jobs), f"{len(results)} of {len(jobs)} walks")
    return results


def say(*words: Any) -> None:
    """Tell the process that started this worker how far it is; called by a job."""
    if _words is not None:
        _words.put(words)


def progress_bar(console: Console) -> Progress:
    """Return a bar that shows share, time and what is done now; nothing without a terminal."""
    return Progress(
        TextColumn("{task.percentage:3.0f} %"),
        BarColumn(bar_width=20),
        TimeElapsedColumn(),
        TextColumn("{task.description}"),
        console=console,
        transient=True,
        disable=not console.is_terminal,
    )


def _listen(words: Any, report: Callable[..., None] | None) -> None:
    while (said := words.get()) is not None:
        if report is not None:
            report(*said)


def _begin_work(words: Any) -> None:
    """Be quiet, leave Ctrl-C to the process that started this one, and end when that ends."""
    global _words  # noqa: PLW0603  a process has one queue
    _words = words
    quieten_drake()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
