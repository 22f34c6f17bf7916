"""Runs on a cluster: the same rows on any, nothing lost and nothing twice when a worker dies."""

import os
import re
import signal
import threading
import time
import warnings
from contextlib import nullcontext

import dask
import psutil
import pytest
from distributed import Client
from distributed.comm import CommClosedError
from distributed.security import Security

from drake_linefoot.errors import InputError, LinefootError
from drake_linefoot.lab.sweep import cluster, dispatch
from drake_linefoot.lab.sweep.cluster import LOST, existing_cluster, local_cluster
from drake_linefoot.lab.sweep.dispatch import Dispatcher
from drake_linefoot.lab.sweep.file import load_sweep
from drake_linefoot.lab.sweep.jobs import Job, jobs
from drake_linefoot.lab.sweep.rows import OUTCOME, RUN
from tests.helpers import deadly
from tests.helpers.clusters import trusted
from tests.helpers.tiny_sweeps import TINY, write_sweep

# The same in every repetition on machines of one kind: all but how the work was done.
REPEATABLE = (*RUN, *OUTCOME, "error")


@pytest.fixture(scope="module")
def two_workers():
    with local_cluster(2) as client:
        yield client


@pytest.fixture
def made(tmp_path):
    return list(jobs(load_sweep(write_sweep(tmp_path))))


def carried_out(client, made, recycle=None):
    """Return rows in order, and what was reported."""
    rows, reports = [], []
    Dispatcher(client, rows.append, reports.append, recycle).run(made)
    return sorted(rows, key=lambda row: (row["group"] == "high", row["index"])), reports


def repeatable(rows):
    return [{name: row[name] for name in (*REPEATABLE, "sampled")} for row in rows]


def test_rows_are_the_same_bit_for_bit_on_every_cluster(two_workers, made):
    first, reports = carried_out(two_workers, made)
    assert reports == []
    assert [row["error"] for row in first] == [""] * 8
    assert len({row["state_hash"] for row in first}) == 8
    assert len({row["worker"] for row in first}) == 2
    with trusted(two_workers) as address, existing_cluster(address) as client:
        by_address, _ = carried_out(client, made[::-1])
    with local_cluster(1) as client:
        alone, _ = carried_out(client, made)
    assert repeatable(first) == repeatable(by_address) == repeatable(alone)
    assert all(row["worker_mb"] > 50.0 and row["wall_seconds"] > 0.0 for row in first)


def test_worker_killed_midway_loses_nothing_and_counts_nothing_twice(two_workers, tmp_path):
    text = TINY.replace("duration: 0.05", "duration: 0.4")
    made = list(jobs(load_sweep(write_sweep(tmp_path, text, runs=3))))
    pids, rows, reports, killed = two_workers.run(os.getpid), [], [], []

    def kill_one_that_works():
        wait_for(lambda: len(rows) > 0)
        wait_for(lambda: any(two_workers.processing().values()))
        killed.extend([address for address, keys in two_workers.processing().items() if keys][:1])
        os.kill(pids[killed[0]], signal.SIGKILL)

    killer = threading.Thread(target=kill_one_that_works)
    killer.start()
    Dispatcher(two_workers, rows.append, reports.append).run(made)
    killer.join()
    assert sorted((row["group"], row["index"]) for row in rows) == sorted(job.key for job in made)
    assert all(row["fell"] is False for row in rows)
    (again,) = [row for row in rows if row["attempts"] > 1]
    assert again["attempts"] == 2
    assert again["worker"] not in killed
    name = f"run {again['index']} of {again['group']}"
    assert reports == [f"worker {killed[0]} died; {name} is done again"]
    alone = Dispatcher(two_workers, rows.append, reports.append)
    alone.run([job for job in made if job.key == (again["group"], again["index"])])
    assert repeatable(rows[-1:]) == repeatable([again])
    wait_for(lambda: len(two_workers.nthreads()) == 2)  # it was replaced


def wait_for(condition, seconds=20.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


def test_a_worker_that_is_killed_while_it_starts_is_started_again():
    """Dask replaces it only later on; here the start of all of them fails."""
    killed = []

    def kill():
        mine = {child.pid for child in psutil.Process().children()}
        while not killed:
            for child in psutil.Process().children():
                if child.pid not in mine and "spawn_main" in " ".join(child.cmdline()):
                    time.sleep(0.3)  # it imports
                    child.kill()
                    killed.append(child.pid)
                    break
            time.sleep(0.01)

    killer = threading.Thread(target=kill, daemon=True)
    killer.start()
    with local_cluster(1) as client:
        killer.join(20.0)
        assert len(killed) == 1
        wait_for(lambda: len(client.nthreads()) == 1)
        assert client.submit(os.getpid).result(timeout=20.0) not in killed


def test_workers_that_never_start_are_said_in_a_line(monkeypatch):
    starts = []

    def fail(**_):
        starts.append(1)
        raise RuntimeError("Nanny failed to start.")

    monkeypatch.setattr(cluster, "LocalCluster", fail)
    message = "the workers cannot be started: Nanny failed to start."
    with pytest.raises(LinefootError, match=message), local_cluster(1):
        pass
    assert len(starts) == cluster.STARTS


@pytest.mark.slow
def test_workers_are_replaced_however_often(monkeypatch):
    monkeypatch.setattr(dispatch, "carry_out", deadly.report_pid)
    monkeypatch.setattr(dispatch, "PATIENCE", 20.0)
    # Dask, left alone, would look after one or two replacements already whether one is missing.
    with dask.config.set({LOST: "2 s"}), local_cluster(1) as client:
        rows, reports = carried_out(
            client, [Job("low", i, 0, {}, "") for i in range(10)], recycle=1
        )
    assert reports == []
    assert len({row["worker_mb"] for row in rows}) == 10


def test_run_that_kills_its_worker_is_done_again_once(two_workers, made, monkeypatch):
    monkeypatch.setattr(dispatch, "carry_out", deadly.die_at_two)
    rows, reports = carried_out(two_workers, made)
    assert [(row["group"], row["index"]) for row in rows] == sorted(
        (job.key for job in made), key=lambda key: (key[0] == "high", key[1])
    )
    lost = [row for row in rows if row["index"] == 2]
    assert [row["error"] for row in lost] == ["its worker died, 2 times"] * 2
    assert [(row["attempts"], row["fell"], row["cause"]) for row in lost] == [
        (2, None, "error")
    ] * 2
    assert [row["attempts"] for row in rows if row["index"] != 2] == [1] * 6
    assert sum("done again" in text for text in reports) == 2
    assert sum("given up after 2 attempts" in text for text in reports) == 2


def test_a_run_that_hangs_is_given_up_and_the_others_go_on(two_workers, monkeypatch):
    monkeypatch.setattr(dispatch, "carry_out", deadly.hang_at_two)
    jobs = [Job("low", i, 0, {}, "", limit=3.0) for i in range(6)]
    rows, reports = carried_out(two_workers, jobs)
    assert [row["index"] for row in rows] == list(range(6))
    assert [row["error"] for row in rows if row["index"] != 2] == [""] * 5
    assert rows[2]["error"] == "took longer than its limit of 3 s"
    assert (rows[2]["attempts"], rows[2]["fell"]) == (1, None)
    assert reports == ["run 2 of low is given up after 3 s"]
    wait_for(lambda: len(two_workers.nthreads()) == 2)  # its worker was replaced


def test_the_limit_of_a_run_grows_with_what_is_simulated(tmp_path, made):
    longer = load_sweep(write_sweep(tmp_path, TINY.replace("duration: 0.05", "duration: 10.05")))
    assert next(jobs(longer)).limit - made[0].limit == pytest.approx(600.0)
    assert made[0].limit > 300.0  # to compile


def test_nobody_without_its_keys_talks_to_a_local_cluster(two_workers):
    address = two_workers.scheduler.address
    assert address.startswith("tls://127.0.0.1:")
    assert all(worker.startswith("tls://127.0.0.1:") for worker in two_workers.nthreads())
    stranger = Security.temporary()
    for words in (
        {"address": address, "security": stranger},
        {"address": address.replace("tls", "tcp")},
    ):
        with pytest.raises(OSError):  # of several kinds
            Client(**words, timeout=2.0, set_as_default=False)


def test_local_workers_are_replaced_after_so_many_runs(two_workers, made, monkeypatch):
    monkeypatch.setattr(dispatch, "carry_out", deadly.report_pid)
    rows, reports = carried_out(two_workers, made, recycle=2)
    pids = [row["worker_mb"] for row in rows]
    assert reports == []
    assert len(rows) == 8
    assert max(pids.count(pid) for pid in pids) <= 2


def test_workers_with_other_code_are_refused(two_workers, made, monkeypatch):
    monkeypatch.setattr(dispatch, "carry_out", deadly.other_code)
    with pytest.raises(LinefootError, match="has code other instead of"):
        carried_out(two_workers, made)


def test_an_interrupt_is_silent_about_what_the_client_had_begun(made):
    class Interrupted:
        as_current = staticmethod(nullcontext)

        def nthreads(self):
            raise KeyboardInterrupt

    async def begun():
        """Is dropped before anybody waits for it."""

    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        begun()
        assert len(said) == 1  # so Python says
        with pytest.raises(KeyboardInterrupt):
            Dispatcher(Interrupted(), made.append, made.append).run(made)
        begun()
        assert len(said) == 1


@pytest.mark.parametrize(
    ("problem", "said"),
    [
        (CommClosedError("in <TCP (closed)>"), "scheduler of the cluster is lost: CommClosedError"),
        (TimeoutError("no answer"), "has no worker, or its scheduler does not answer: no answer"),
    ],
)
def test_a_scheduler_that_is_lost_is_told_from_one_without_workers(made, problem, said):
    class Alone:
        as_current = staticmethod(nullcontext)

        def nthreads(self):
            raise problem

    with pytest.raises(LinefootError, match=re.escape(said)):
        Dispatcher(Alone(), made.append, made.append).run(made)


def test_run_that_cannot_be_simulated_is_a_row(two_workers, made):
    bad = made[0].__class__("low", 0, 1, {}, "gait: {step_width: 9.0}")
    rows, reports = carried_out(two_workers, [bad, made[1]])
    assert reports == []
    assert [row["fell"] for row in rows] == [None, False]
    assert rows[0]["error"].startswith("ScenarioError: scenario: gait.step_width = 9.0: must lie")


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "nonsense://x", ""])
def test_scheduler_that_does_not_answer_is_refused(address, monkeypatch):
    monkeypatch.setattr("drake_linefoot.lab.sweep.cluster.ANSWER", 0.5)
    with (
        pytest.raises(InputError, match="no scheduler of dask"),
        existing_cluster(address),
    ):
        pass
