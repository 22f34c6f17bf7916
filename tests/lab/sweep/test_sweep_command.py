"""The command: what it writes, and how it goes on after a kill or Ctrl-C."""

import json
import os
import signal
import sqlite3
import subprocess
import sys
import time
from contextlib import closing

import psutil
import pyarrow.parquet
import pytest

from drake_linefoot.lab import cli
from drake_linefoot.lab.sweep.main import RECYCLE
from drake_linefoot.resources import PACKAGE
from tests.helpers.clusters import existing
from tests.helpers.command_line import refuse
from tests.helpers.tiny_sweeps import write_sweep

LONGER = """
name: longer
scenario: stand
runs: 6
set: {segments: [{duration: 0.2}]}
"""


def begin(file, out, *words):
    """Start the command in a process group of its own."""
    command = [sys.executable, "-m", "drake_linefoot", "sweep", file, "--out", out, *words]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    environment = {**os.environ, "PYTHONPATH": str(PACKAGE.parent)}
    return subprocess.Popen([*map(str, command)], start_new_session=True, env=environment, **pipes)


def journal_rows(out):
    """Rows of the journal, which a sweep may be writing."""
    file = out / "journal.sqlite"
    if not file.exists() or not file.stat().st_size:
        return []
    with closing(sqlite3.connect(f"file:{file}?mode=ro", uri=True)) as connection:
        connection.row_factory = sqlite3.Row
        if not connection.execute("SELECT * FROM sqlite_schema").fetchall():
            return []
        return [dict(row) for row in connection.execute("SELECT * FROM runs")]


def wait_for_rows(process, out, n):
    end = time.monotonic() + 60.0
    while len(journal_rows(out)) < n:
        assert process.poll() is None
        assert time.monotonic() < end
        time.sleep(0.02)


def wait_until_gone(processes):
    _, alive = psutil.wait_procs(processes, timeout=20.0)
    assert alive == []


def rows_of(out):
    """Rows of the table by run, each there once."""
    rows = pyarrow.parquet.read_table(out / "runs.parquet").to_pylist()
    by_key = {(row["group"], row["index"]): row for row in rows}
    assert len(by_key) == len(rows)
    return by_key


def test_killed_command_goes_on_with_what_is_missing(tmp_path):
    file, out = write_sweep(tmp_path, LONGER), tmp_path / "out"
    process = begin(file, out, "--workers", "2", "--replays", "0")
    wait_for_rows(process, out, 2)
    workers = psutil.Process(process.pid).children(recursive=True)
    process.kill()
    process.communicate(timeout=20)
    wait_until_gone(workers)
    before = journal_rows(out)
    process = begin(file, out, "--workers", "2", "--replays", "1")
    said, complaint = process.communicate(timeout=120)
    assert (process.returncode, complaint) == (0, "")
    assert f"{len(before)} runs were done before" in said
    assert said.splitlines()[-1] == str(out / "report.html")
    rows = rows_of(out)
    assert len(rows) == 6
    assert len(journal_rows(out)) == 6
    for row in before:
        assert rows[row["group"], row["index"]]["wall_seconds"] == row["wall_seconds"]
    summary = json.loads((out / "summary.json").read_text(encoding="utf-8"))
    assert {name: group["n"] for name, group in summary["groups"].items()} == {"longer": 6}
    page = (out / "report.html").read_text(encoding="utf-8")
    replays = sorted((out / "replays").iterdir())
    assert len(replays) == 1
    assert all(f'href="replays/{replay.name}"' in page for replay in replays)
    for replay in replays:
        assert "<title>" in replay.read_text(encoding="utf-8")[:2000]
        assert any(row["state_hash"] in replay.name for row in rows.values())


def test_ctrl_c_keeps_what_is_done_and_says_how_to_go_on(tmp_path):
    file, out = write_sweep(tmp_path, LONGER, runs=200), tmp_path / "out"
    process = begin(file, out, "--workers", "2")
    wait_for_rows(process, out, 1)
    os.killpg(process.pid, signal.SIGINT)
    said, complaint = process.communicate(timeout=60)
    assert (process.returncode, complaint) == (130, "linefoot: interrupted\n")
    done = len(journal_rows(out))
    assert f"{done} runs are kept in {out}; the same command goes on" in " ".join(said.split())
    assert len(rows_of(out)) == done
    assert "of 200 runs are done" in (out / "report.html").read_text(encoding="utf-8")


def test_longer_sweep_and_other_sweep(tmp_path, capsys):
    file, out = write_sweep(tmp_path, runs=1), tmp_path / "out"
    words = ["sweep", str(file), "--out", str(out), "--replays", "0", "--workers", "1"]
    assert cli.main(words) == 0
    first = rows_of(out)
    write_sweep(tmp_path, runs=2)
    assert cli.main(words) == 0
    longer = rows_of(out)
    assert {key: longer[key] for key in first} == first
    assert len(longer) == 4
    printed = capsys.readouterr().out
    assert "won, lost (p)" in printed
    assert "0, 0 (1)" in printed  # all stand
    assert "no outcome" not in printed  # it would be a column of zeros
    write_sweep(tmp_path, seed=2)
    assert "journal.sqlite: the journal is of the sweep tiny (" in refuse(capsys, *words)
    assert rows_of(out) == longer
    write_sweep(tmp_path, seed=2, runs=1)
    assert cli.main([*words, "--fresh"]) == 0
    assert set(rows_of(out)) == set(first)
    assert rows_of(out) != first


def test_it_runs_in_another_simulator_beside_the_usual_one(tmp_path, monkeypatch):
    pytest.importorskip("mujoco", reason="MuJoCo is not installed: the extra mujoco")
    monkeypatch.chdir(tmp_path)
    file = write_sweep(tmp_path, runs=1)
    words = ["sweep", str(file), "--replays", "0", "--workers", "1"]
    assert [cli.main(words), cli.main([*words, "--simulator", "mujoco"])] == [0, 0]
    usual, other = (rows_of(tmp_path / "out" / "sweep" / name) for name in ("tiny", "tiny-mujoco"))
    assert usual.keys() == other.keys() == {("low", 0), ("high", 0)}
    for key, row in usual.items():
        assert not (row["fell"] or other[key]["fell"])
        assert row["seed"] == other[key]["seed"]
        assert row["state_hash"] != other[key]["state_hash"]


def test_a_scheduler_that_is_killed_ends_a_sweep_in_a_line(tmp_path):
    file, out = write_sweep(tmp_path, LONGER, runs=200), tmp_path / "out"
    with existing(tmp_path) as (cluster, address):
        process = begin(file, out, "--scheduler", address)
        wait_for_rows(process, out, 1)
        cluster.kill()
        said, complaint = process.communicate(timeout=60)
    assert process.returncode == 3
    (line,) = complaint.splitlines()
    assert line.startswith("linefoot: the scheduler of the cluster is lost")
    done = len(journal_rows(out))
    assert f"{done} runs are kept in {out}; the same command goes on" in " ".join(said.split())


def test_runs_without_an_outcome_are_done_again_alone(tmp_path):
    file, out = write_sweep(tmp_path, runs=2), tmp_path / "out"
    words = ["sweep", str(file), "--out", str(out), "--replays", "0", "--workers", "1"]
    assert cli.main(words) == 0
    first = rows_of(out)
    lost = next(iter(first))
    error = "its worker was killed by SIGKILL, 2 times"
    with closing(sqlite3.connect(out / "journal.sqlite")) as connection:
        change = "UPDATE runs SET error = ?, fell = NULL, state_hash = NULL, wall_seconds = 0.5 "
        connection.execute(change + 'WHERE "group" = ? AND "index" = ?', (error, *lost))
        connection.commit()
    assert cli.main(words) == 3  # and does nothing
    assert (rows_of(out)[lost]["error"], rows_of(out)[lost]["wall_seconds"]) == (error, 0.5)
    for _ in range(2):
        assert cli.main([*words, "--retry"]) == 0
        again = rows_of(out)
        assert again[lost]["state_hash"] == first[lost]["state_hash"]
        assert {k: row for k, row in again.items() if k != lost} == {
            k: row for k, row in first.items() if k != lost
        }


def test_a_folder_of_something_else_is_refused_and_files_of_others_stay(tmp_path, capsys):
    file, out = write_sweep(tmp_path, runs=1), tmp_path / "out"
    out.mkdir()
    (out / "report.html").write_text("mine")
    words = ["sweep", str(file), "--out", str(out), "--replays", "0", "--workers", "1"]
    assert "holds other files (report.html); name an empty" in refuse(capsys, *words)
    assert (out / "report.html").read_text() == "mine"
    assert len(list(out.iterdir())) == 1
    (out / "report.html").unlink()
    (out / ".DS_Store").touch()
    assert cli.main(words) == 0
    replays = out / "replays"
    replays.mkdir()
    old = replays / "low-0-0123456789abcdef.html"
    for path in (old, replays / "mine.html", replays / "low-best.html", replays / "other-0-0.html"):
        path.touch()
    assert cli.main(words) == 0
    assert {path.name for path in replays.iterdir()} == {
        *("mine.html", "low-best.html", "other-0-0.html")
    }


def test_bad_words_are_refused(capsys, tmp_path):
    file = str(write_sweep(tmp_path))
    assert "Missing argument 'FILE'" in refuse(capsys, "sweep")
    assert "'--workers': '0' must be a whole number" in refuse(
        capsys, "sweep", file, "--workers", "0"
    )
    assert "'--replays': '-1' must be a whole number" in refuse(
        capsys, "sweep", file, "--replays", "-1"
    )
    both = ("sweep", file, "--workers", "2", "--scheduler", "tcp://a:1")
    assert "'--workers': is for this machine" in refuse(capsys, *both)
    assert "cannot be read" in refuse(capsys, "sweep", "nowhere.yaml")
    (tmp_path / "file").touch()
    assert "cannot be written" in refuse(capsys, "sweep", file, "--out", str(tmp_path / "file"))


@pytest.mark.slow
def test_memory_of_a_worker_stays_bounded(tmp_path):
    """Two workers carry out 40 runs each, one after the other."""
    file, out = write_sweep(tmp_path, runs=RECYCLE), tmp_path / "out"
    process = begin(file, out, "--workers", "1", "--replays", "0")
    _, complaint = process.communicate(timeout=600)
    assert (process.returncode, complaint) == (0, "")
    rows = sorted(rows_of(out).values(), key=lambda row: row["index"])
    resident = [row["worker_mb"] for row in rows]
    assert len(resident) == 2 * RECYCLE
    assert max(resident) < resident[0] + 160.0  # [MB]
    assert max(resident[RECYCLE:]) < max(resident[:RECYCLE]) + 20.0
