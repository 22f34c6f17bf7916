"""A small part of fault injection, and that it notices what is wrong."""

import json
import subprocess
import sys

import numpy as np
import psutil
import pytest

from drake_linefoot.errors import InputError
from drake_linefoot.mpc import solve
from studies.fault_injection import bad_inputs as module
from studies.fault_injection import solver_faults as solver_module
from studies.fault_injection import sweep_kills as sweep_module
from studies.fault_injection.__main__ import PAGE, fault_injection, page, summed, trials
from studies.fault_injection.again import Look, summary
from studies.fault_injection.bad_inputs import KINDS, bad_inputs
from studies.fault_injection.faults import remains
from studies.fault_injection.solver_faults import FAULTS, MPC, Fault, raising, solver_faults
from studies.fault_injection.sweep_kills import WHOM, WORKER, killed, sweep_kills


@pytest.mark.parametrize("kind", KINDS)
def test_odd_files_are_taken_or_refused(tmp_path, kind):
    tally = bad_inputs(kind, 40, 0, tmp_path)
    assert tally.wrong == []
    assert tally.ends.total() == 40
    assert tally.ends["refused"] > 10  # most are bad indeed
    assert set(tally.ends) <= {"taken", "refused"}


def break_down(file):
    raise KeyError("gait")


def exit_of_drake(file):
    raise SystemExit("assertion")


def refuse_at_length(file):
    error = InputError(file, "gait", "x", "must be")
    error.args = ("must be\none of " + "many " * 1000,)  # which it does not do by itself
    raise error


@pytest.mark.parametrize("load", [break_down, exit_of_drake, refuse_at_length])
def test_what_is_wrong_is_noticed(tmp_path, monkeypatch, load):
    make = KINDS["sweeps"][0]
    monkeypatch.setitem(module.KINDS, "sweeps", (make, load, 5))
    tally = bad_inputs("sweeps", 5, 0, tmp_path)
    assert len(tally.wrong) == 5
    text = page({"tallies": summed([tally])})
    assert text.splitlines()[2] == "**5 tries, 5 wrong.**"
    assert "| sweeps | 5 | 5 " in text and "| 5 |" in text and tally.wrong[0] in text


def test_files_of_a_seed_are_the_same_every_time(tmp_path):
    for make, _, _ in KINDS.values():
        first, again = (make(np.random.default_rng(5), tmp_path).read_bytes() for _ in range(2))
        assert first == again


def test_faults_of_solvers_are_walked_through_or_are_falls(tmp_path, monkeypatch):
    few = [fault for fault in FAULTS if fault.name in ("torque NaN", "OSQP fails", "Hessian 0")]
    monkeypatch.setattr(solver_module, "FAULTS", few)
    tally = solver_faults(3, 0, tmp_path)
    assert tally.wrong == []
    ends = ["counted and walked through", "fell with its reason", "walked through"]
    assert sorted(tally.ends) == ends
    owners = [getattr(fault.owner, fault.function) for fault in FAULTS]
    assert all(function.__name__ != "call" for function in owners)  # they are whole again


def test_the_walk_that_compiles_meets_no_fault(tmp_path, monkeypatch):
    """It is none of those that are judged, and its end would be that of the first ones."""
    steps, whole = [], solve.MpcSolver.solve

    def compiles():
        steps.append("compiles" if solve.MpcSolver.solve is whole else "compiles broken")

    monkeypatch.setattr(solver_module, "warm_up", compiles)
    monkeypatch.setattr(solver_module, "_walked", lambda *_: steps.append("walk") or ("fell", ""))
    made = Fault("a", solve.MpcSolver, "solve", raising(KeyError("gait")))
    monkeypatch.setattr(solver_module, "FAULTS", (made,))
    solver_faults(2, 0, tmp_path)
    assert steps == ["compiles", "walk", "walk"]


@pytest.mark.parametrize("fault", ["not counted", "unforeseen", "not reached"])
def test_a_fault_that_ends_otherwise_is_noticed(tmp_path, monkeypatch, fault):
    first = (10**6, 10**6 + 1) if fault == "not reached" else (2, 5)
    spoil = raising(KeyError("gait")) if fault == "unforeseen" else lambda result: result
    made = Fault(fault, solve.MpcSolver, "solve", spoil, first, MPC)
    monkeypatch.setattr(solver_module, "FAULTS", (made,))
    tally = solver_faults(1, 0, tmp_path)
    said = {"not counted": "0 counted of", "unforeseen": "KeyError", "not reached": "never broken"}
    assert said[fault] in tally.wrong[0]


@pytest.mark.slow
def test_a_sweep_goes_on_after_a_kill(tmp_path, monkeypatch):
    monkeypatch.setattr(sweep_module, "LATEST", 6.0)  # the first runs are done after 4 s
    tally = sweep_kills(2, 1, tmp_path)  # a worker, a scheduler
    assert tally.wrong == []
    assert tally.ends.total() == 2
    assert set(tally.ends) <= {*WHOM, "had ended before", "no worker yet"}


FAMILY = """
import multiprocessing, time
if __name__ == "__main__":
    context = multiprocessing.get_context("forkserver")
    worker = context.Process(target=time.sleep, args=(600.0,))
    worker.start()
    print(worker.pid, flush=True)
    worker.join()
"""


def test_who_is_killed_is_a_worker_and_not_the_server_that_makes_them(tmp_path):
    (tmp_path / "family.py").write_text(FAMILY, encoding="utf-8")
    command = [sys.executable, str(tmp_path / "family.py")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        worker = psutil.Process(int(process.stdout.readline()))
        server = worker.parent()
        assert server.pid != process.pid
        assert killed(process, WORKER, 0.0) == WORKER
        assert process.wait(60) == 0  # it has joined the worker, whom nobody kept alive
        assert not worker.is_running() or worker.status() == psutil.STATUS_ZOMBIE
        assert killed(process, WORKER, 0.0) == "had ended before"


def test_the_page_is_that_of_its_data_and_begins_with_what_was_found(tmp_path):
    stored = PAGE.with_suffix(".json").read_text(encoding="utf-8")
    file = tmp_path / "page.md"
    file.with_suffix(".json").write_text(stored, encoding="utf-8")
    fault_injection(out=file, redraw=True)
    text = file.read_text(encoding="utf-8")
    assert text == PAGE.read_text(encoding="utf-8")
    tried = sum(sum(tally["ends"].values()) for tally in json.loads(stored)["tallies"])
    found = f"**{tried} tries, 0 wrong; 60 minutes of walking, 0 solver failures.**"
    assert text.splitlines()[2] == found and "16357 steps" in text


@pytest.mark.slow
def test_a_long_walk_is_measured_and_what_was_counted_stays(tmp_path, monkeypatch):
    file = tmp_path / "page.md"
    counted = {"tallies": [{"what": "kills", "ends": {"survived": 3}, "wrong": []}]}
    file.with_suffix(".json").write_text(json.dumps(counted), encoding="utf-8")
    monkeypatch.setattr("studies.fault_injection.hour.DURATION", 2.0)
    fault_injection(out=file, hour=True)
    text, data = (file.with_suffix(end).read_text(encoding="utf-8") for end in (".md", ".json"))
    assert "| kills | 3 | 3 survived | 0 |" in text
    assert "| simulated | 2.000 s, " in text and "upright" in text
    walked = json.loads(data)["hour"]
    assert walked["wrong"] == []
    assert 100.0 < walked["peak"] < 2000.0 and 2.0 < walked["folder"] < 50.0


@pytest.mark.slow
def test_drives_and_sweeps_are_watched_and_what_was_counted_stays(tmp_path, monkeypatch):
    file = tmp_path / "page.md"
    counted = {"tallies": [{"what": "kills", "ends": {"survived": 3}, "wrong": []}]}
    file.with_suffix(".json").write_text(json.dumps(counted), encoding="utf-8")
    few = {"LENGTH": 1.2, "LARGEST_SLOWING": 10.0, "LARGEST_GROWTH": 200.0}
    for name, value in few.items():  # three of each, of which caches fill, on a busy machine
        monkeypatch.setattr(f"studies.fault_injection.again.{name}", value)
    fault_injection(out=file, again=True, minutes=0.0)
    text, data = (file.with_suffix(end).read_text(encoding="utf-8") for end in (".md", ".json"))
    assert "| kills | 3 | 3 survived | 0 |" in text
    assert "| drives of 1.2 s, recorded, " in text and "| sweeps of 2 runs, " in text
    assert "## 0 minutes of drives and sweeps" in text
    found = json.loads(data)["again"]
    assert found["wrong"] == [] and [each["number"] for each in found["series"]] == [3, 3]


def test_what_grows_or_slows_down_is_noticed():
    flat = [Look(2.0 + 0.1 * (i % 3), 500.0 + 10.0 * (i % 2)) for i in range(30)]
    assert summary("drives", flat).wrong() == []
    leaks = summary("drives", [look._replace(memory=500.0 + 3 * i) for i, look in enumerate(flat)])
    assert leaks.wrong() == ["drives: memory grew by 60 MB"]
    slows = summary("drives", [look._replace(seconds=1.0 + i) for i, look in enumerate(flat)])
    assert slows.wrong() == ["drives: 25.50 s at the end, 5.50 s before"]


def test_a_half_written_result_is_noticed(tmp_path):
    assert remains(tmp_path / "none", "linefoot: interrupted") == ""
    assert "traceback" in remains(tmp_path / "none", "Traceback (most recent call last):\n\nX\n")
    (tmp_path / "log.arrow").write_bytes(b"half")
    assert "half-written" in remains(tmp_path, "")


def test_everything_is_tried(tmp_path):
    counts = [kind[2] for kind in KINDS.values()]
    assert sum(counts) >= 10_000
    assert len(trials(0, 1.0, tmp_path)) == 2 * len(KINDS) + 4
    assert len({fault.name for fault in FAULTS}) >= 20
