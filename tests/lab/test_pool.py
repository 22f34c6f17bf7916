"""The pool: what crashes, hangs or dies has an error, the others go on, none is left behind."""

import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import Future
from pathlib import Path

import psutil
import pytest
from pebble import ProcessPool

from drake_linefoot.errors import LinefootError
from drake_linefoot.lab import pool as pools
from drake_linefoot.lab.pool import Pool
from tests.helpers import jobs

ROOT = Path(__file__).parents[2]
SHORT = 5.0  # [s], a limit


@pytest.fixture(scope="module")
def pool():
    with Pool(2) as made:
        yield made


def results(pool, function, some, limit=60.0, report=lambda job, what: None):
    """Return what became of each job, in their order."""
    found = list(pool.run(function, some, lambda job: limit, report))
    assert len(found) == len(some)
    return [next(one for one in found if one.job == job) for job in some]


def wait_for(condition, seconds=20.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


def test_results_are_the_same_on_any_number_of_processes(pool):
    some = list(range(7))
    found = results(pool, jobs.double, some)
    assert [(one.value, one.error, one.attempts) for one in found] == [(2 * i, "", 1) for i in some]
    with Pool(1) as alone:
        assert results(alone, jobs.double, some) == found


def test_what_crashes_or_hangs_has_an_error_and_the_others_go_on(pool):
    reports = []
    found = results(pool, jobs.trouble, range(8), SHORT, lambda *said: reports.append(said))
    assert [one.value for one in found] == [0, 1, None, None, None, 5, 6, 7]
    assert {one.job: (one.error, one.attempts) for one in found if one.error} == {
        2: ("its worker was killed by SIGKILL, 2 times", 2),
        3: ("its worker ended with status 7, 2 times", 2),
        4: ("took longer than its limit of 5 s", 1),
    }
    assert sorted(reports) == [
        (2, "its worker was killed by SIGKILL"),
        (3, "its worker ended with status 7"),
    ]


def test_a_job_that_runs_out_of_memory_has_an_error(pool):
    errors = [one.error for one in results(pool, jobs.too_much, range(3))]
    assert errors == ["", "its worker ran out of memory", ""]


def test_a_job_is_done_again_when_its_process_dies(pool, tmp_path):
    (one,) = results(pool, jobs.die_once, [tmp_path / "died"])
    assert (one.value, one.error, one.attempts) == ("done", "", 2)


def test_an_error_of_a_job_is_that_of_the_run(pool):
    with pytest.raises(ValueError, match="3 is refused"):
        list(pool.run(jobs.refuse, [3]))
    assert results(pool, jobs.double, [1])[0].value == 2  # it is still there


def test_processes_are_replaced_after_so_many_jobs():
    with Pool(1, recycle=2) as pool:
        pids = [one.value for one in results(pool, jobs.pid_of, range(6))]
    assert sorted(pids.count(pid) for pid in set(pids)) == [2, 2, 2]


def test_idle_processes_that_are_killed_cost_nothing():
    with Pool(2) as pool:
        pids = {one.value for one in results(pool, jobs.pid_of, range(20))}
        for pid in pids:
            os.kill(pid, signal.SIGKILL)
        wait_for(lambda: not any(psutil.pid_exists(pid) for pid in pids))
        assert [one.value for one in results(pool, jobs.double, range(4))] == [0, 2, 4, 6]


def test_jobs_that_are_lost_as_the_pool_breaks_are_done_again(monkeypatch):
    schedule = ProcessPool.schedule

    def lose(pool, *args, **options):
        monkeypatch.setattr(ProcessPool, "schedule", schedule)
        pool.stop()
        return Future()  # that nobody ever completes

    with Pool(1) as pool:
        monkeypatch.setattr(ProcessPool, "schedule", lose)
        assert [one.value for one in results(pool, jobs.double, [3])] == [6]


def test_processes_that_never_start_are_said_in_a_line(monkeypatch):
    monkeypatch.setattr(pools, "_begin_work", jobs.refuse)  # it wants an argument
    with pytest.raises(LinefootError, match="die before they take a job"), Pool(1) as pool:
        list(pool.run(jobs.double, [1]))


def test_an_interrupt_does_not_wait_for_what_is_being_done():
    with Pool(1) as pool:
        (one,) = results(pool, jobs.pid_of, [0])
        threading.Timer(1.0, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
        start = time.monotonic()
        with pytest.raises(KeyboardInterrupt):
            list(pool.run(jobs.sleep, [0]))
    assert time.monotonic() - start < 10.0
    assert not psutil.pid_exists(one.value)


PARENT = """
from drake_linefoot.lab.pool import Pool
from tests.helpers.jobs import double, sleep

if __name__ == "__main__":
    with Pool(1) as pool:
        list(pool.run(double, [0]))
        print("busy", flush=True)
        list(pool.run(sleep, [0]))
"""


def test_processes_end_with_the_one_that_started_them(tmp_path):
    script = tmp_path / "parent.py"
    script.write_text(PARENT)
    env = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), *sys.path])}
    with subprocess.Popen([sys.executable, script], stdout=subprocess.PIPE, env=env) as parent:
        assert parent.stdout.readline() == b"busy\n"
        children = psutil.Process(parent.pid).children(recursive=True)
        assert len(children) >= 2
        parent.kill()
    _, left = psutil.wait_procs(children, timeout=60)
    assert left == []
