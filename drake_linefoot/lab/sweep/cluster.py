"""The processes that carry out runs: a local cluster of dask.distributed, or an existing one."""

import logging
import signal
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

import dask
from distributed import Client, LocalCluster
from distributed.security import Security

from drake_linefoot.errors import InputError, LinefootError

ANSWER = 10.0  # [s] within which a scheduler must answer
STARTS = 3  # of all workers, until none is killed meanwhile
PRELOAD = "drake_linefoot.lab.sweep.worker"
# So long after a worker was lost, dask looks whether it is back; if it happens to be lost again
# just then, it is not replaced any more.
LOST, NEVER = "distributed.deploy.lost-worker-timeout", "365 days"


@contextmanager
def local_cluster(workers: int) -> Iterator[Client]:
    """Start worker processes on this machine; gives a client of them.

    Each has one thread, and is replaced when it dies. Nothing listens but to this machine, and
    what gives work to the workers must have keys that are made here and kept in memory: whoever
    else has an account on the machine cannot let them run code.

    Raises:
        LinefootError: the workers cannot be started.
    """
    with dask.config.set({LOST: NEVER}), ExitStack() as stack:
        with uninterrupted():
            cluster = stack.enter_context(_started(workers))
            client = stack.enter_context(Client(cluster, set_as_default=False))
        yield client


def _started(workers: int, again: int = STARTS - 1) -> LocalCluster:
    """Start the processes; anew when one is killed so early that dask does not replace it."""
    try:
        return LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            processes=True,
            host="127.0.0.1",
            protocol="tls",
            security=Security.temporary(),
            dashboard_address="127.0.0.1:0",  # a free one, not 8787 with a warning
            silence_logs=logging.CRITICAL,
            preload=[PRELOAD],
        )
    except RuntimeError as error:
        if not again:
            raise LinefootError(f"the workers cannot be started: {error}") from error
    return _started(workers, again - 1)


@contextmanager
def existing_cluster(address: str) -> Iterator[Client]:
    """Connect to a cluster by the address of its scheduler; gives a client of it.

    Its workers must have the same drake_linefoot installed.

    Raises:
        InputError: no scheduler answers there.
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
        yield client


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Ignore Ctrl-C inside, and in the processes that are started inside.

    A new process handles Ctrl-C until it has loaded `PRELOAD`, and would print its traceback.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
