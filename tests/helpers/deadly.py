"""Stand-ins for the work of a worker, which can load them by name."""

import ctypes
import os
import signal

from drake_linefoot.lab.sweep.provenance import made_with
from drake_linefoot.lab.sweep.worker import within
from tests.helpers.tiny_sweeps import made_up_row


def die_at_two(job):
    """Die whenever run 2 is begun."""
    if job.index == 2:
        os.kill(os.getpid(), signal.SIGKILL)
    return made_up_row(group=job.group, index=job.index), made_with()


def hang_at_two(job):
    """Hang in run 2, as compiled code does: no other thread of Python goes on."""
    with within(job.limit):
        if job.index == 2:
            ctypes.PyDLL(None).sleep(1000)
    return made_up_row(group=job.group, index=job.index), made_with()


def report_pid(job):
    """Say which process did it."""
    return made_up_row(group=job.group, index=job.index, worker_mb=os.getpid()), made_with()


def other_code(job):
    """Be of another version."""
    return made_up_row(group=job.group, index=job.index), {**made_with(), "code": "other"}
