"""Runs on worker processes and on clusters: the same rows, and a row of whatever goes wrong."""

import dataclasses

import pytest
from distributed import LocalCluster

from drake_linefoot.errors import InputError, LinefootError
from drake_linefoot.lab.pool import Done, Pool
from drake_linefoot.lab.results.judge import OUTCOME
from drake_linefoot.lab.sweep import cluster, main
from drake_linefoot.lab.sweep.cluster import carry_out_apart, existing_cluster, run_on_cluster
from drake_linefoot.lab.sweep.file import load_sweep
from drake_linefoot.lab.sweep.jobs import Job, jobs
from drake_linefoot.lab.sweep.rows import RUN, problem_of
from drake_linefoot.lab.sweep.worker import carry_out
from tests.helpers.tiny_sweeps import TINY, made_up_row, write_sweep

REPEATABLE = (*RUN, "sampled", *OUTCOME, "error")  # all but how the work was done


@pytest.fixture(scope="module")
def threads():
    """A cluster of threads; what they carry out is in processes of its own."""
    with LocalCluster(
        n_workers=2,
        threads_per_worker=1,
        processes=False,
        host="127.0.0.1",
        protocol="tcp",
        dashboard_address="127.0.0.1:0",
    ) as made:
        yield made


@pytest.fixture
def made(tmp_path):
    return list(jobs(load_sweep(write_sweep(tmp_path, runs=2))))


def repeatable(done):
    rows = [one.value[0] for one in done]
    rows.sort(key=lambda row: (row["group"], row["index"]))
    return [{name: row[name] for name in REPEATABLE} for row in rows]


def test_rows_are_the_same_bit_for_bit_on_processes_and_on_a_cluster(threads, made):
    with Pool(2) as pool:
        first = list(pool.run(carry_out, made))
    with existing_cluster(threads.scheduler_address) as client:
        theirs = list(run_on_cluster(client, made[1::-1]))
    with Pool(1) as pool:
        alone = list(pool.run(carry_out, made[::-1]))
    assert repeatable(first) == repeatable(alone)
    assert repeatable(one for one in first if one.job.index == 0) == repeatable(theirs)
    rows = [one.value[0] for one in (*first, *theirs)]
    assert [problem_of(row) for row in rows] == [""] * 6
    assert len({row["state_hash"] for row in rows}) == 4
    assert len({row["worker"] for row in rows[4:]}) == 2  # a process each
    assert all(row["worker_mb"] > 50.0 and row["wall_seconds"] > 0.0 for row in rows)


def test_run_that_cannot_be_simulated_is_a_row():
    row, _ = carry_out(Job("low", 0, 1, {}, "gait: {step_width: 9.0}"))
    assert row["fell"] is None
    assert row["error"].startswith("ScenarioError: scenario: gait.step_width = 9.0: must lie")
    assert problem_of(row) == ""


def test_a_run_on_a_cluster_that_hangs_or_crashes_is_one_that_says_so(monkeypatch):
    hangs = Job("low", 0, 1, {}, "", limit=0.2)  # less than it takes to start
    assert carry_out_apart(hangs) == Done(hangs, None, "took longer than its limit of 0 s", 1)
    monkeypatch.setattr(cluster, "WORKER", "tests.helpers.crash")
    crashes = dataclasses.replace(hangs, limit=60.0)
    error = "its worker was killed by SIGABRT, 2 times"
    assert carry_out_apart(crashes) == Done(crashes, None, error, 2)


def test_the_limit_of_a_run_grows_with_what_is_simulated(tmp_path, made):
    longer = load_sweep(write_sweep(tmp_path, TINY.replace("duration: 0.05", "duration: 10.05")))
    assert next(jobs(longer)).limit - made[0].limit == pytest.approx(600.0)
    assert made[0].limit > 300.0  # to compile


def test_workers_with_other_code_are_refused(made):
    other = Done(made[0], (made_up_row(), {**main.made_with(), "controller": "other"}))
    with pytest.raises(LinefootError, match="has controller other instead of"):
        main._row_of(other)


def test_a_run_without_a_value_is_a_row(made):
    row = main._row_of(Done(made[0], None, "took longer than its limit of 3 s"))
    assert (row["group"], row["index"], row["cause"], row["fell"]) == ("low", 0, "error", None)
    assert row["error"] == "took longer than its limit of 3 s"
    assert problem_of(row) == ""


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "nonsense://x", ""])
def test_scheduler_that_does_not_answer_is_refused(address, monkeypatch):
    monkeypatch.setattr(cluster, "ANSWER", 0.5)
    with (
        pytest.raises(InputError, match="no scheduler of dask"),
        existing_cluster(address),
    ):
        pass


def test_a_cluster_without_workers_is_said(threads, monkeypatch):
    monkeypatch.setattr(cluster, "PATIENCE", 0.2)
    with (
        LocalCluster(
            loop=threads.loop,  # a loop of its own must start within 10 s, or it is left half made
            n_workers=0,
            processes=False,
            host="127.0.0.1",
            protocol="tcp",
            dashboard_address="127.0.0.1:0",
        ) as empty,
        pytest.raises(LinefootError, match="the cluster has no worker"),
        existing_cluster(empty.scheduler_address),
    ):
        pass
