"""The processes that carry out walks: one that dies is told, and none is left behind."""

import multiprocessing
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest

from drake_linefoot.errors import LinefootError
from studies.common.pool import workers


def double(x):
    return 2 * x


def die(x):
    os.kill(os.getpid(), signal.SIGKILL)


def sleep(x):
    time.sleep(600.0)


def test_results_come_in_order_and_no_process_is_left():
    with workers(2) as pool:
        assert list(pool.map(double, range(5))) == [0, 2, 4, 6, 8]
    assert multiprocessing.active_children() == []


def test_a_process_that_dies_is_told():
    with pytest.raises(LinefootError, match="a worker process died"), workers(1) as pool:
        list(pool.map(die, range(2)))
    assert multiprocessing.active_children() == []


def test_an_error_does_not_wait_for_what_is_being_done():
    with pytest.raises(KeyboardInterrupt), workers(1) as pool:
        pool.submit(sleep, 0)
        time.sleep(1.0)
        raise KeyboardInterrupt
    assert multiprocessing.active_children() == []


PARENT = """
import time
from tests.studies.common.test_pool import double, sleep
from studies.common.pool import workers

if __name__ == "__main__":
    with workers(1) as pool:
        pool.submit(double, 0).result()
        pool.submit(sleep, 0)
        print("busy", flush=True)
        time.sleep(600.0)
"""


def test_processes_end_with_the_one_that_started_them(tmp_path):
    script = tmp_path / "parent.py"
    script.write_text(PARENT)
    env = {**os.environ, "PYTHONPATH": os.pathsep.join([str(Path(__file__).parents[3]), *sys.path])}
    with subprocess.Popen([sys.executable, script], stdout=subprocess.PIPE, env=env) as parent:
        assert parent.stdout.readline() == b"busy\n"
        children = psutil.Process(parent.pid).children(recursive=True)
        assert children
        parent.kill()
    _, left = psutil.wait_procs(children, timeout=60)
    assert left == []
