"""How `linefoot walk` ends: a fall, an interrupt, an error, a crash."""

import json
import os
import re
import signal
import tempfile
import threading
from dataclasses import replace
from pathlib import Path

import pytest

from drake_linefoot.errors import SolverError
from drake_linefoot.lab import cli
from drake_linefoot.lab.simulation import run as simulation
from drake_linefoot.lab.simulation.recording import Run
from drake_linefoot.wbc.control import WholeBodyControl
from tests.helpers.command_line import SHORT_WALK


def test_fall_is_status_1_and_everything_is_written(capsys, tmp_path, monkeypatch):
    simulate = simulation.simulate

    def fall(*args, **options):
        run = simulate(*args, **options)
        return replace(run, fell=True, fall_time=0.1, fall_reason="torso [low]")

    monkeypatch.setattr(simulation, "simulate", fall)
    assert cli.main([*SHORT_WALK, "--out", str(tmp_path / "out")]) == 1
    assert "The robot FELL at 0.100 s: torso [low]" in capsys.readouterr().out
    assert json.loads((tmp_path / "out/metrics.json").read_text())["fell"] is True


def test_solver_that_gives_up_is_status_3(capsys, tmp_path, monkeypatch):
    def give_up(*_, **__):
        raise SolverError("contact", "infeasible")

    monkeypatch.setattr(simulation, "simulate", give_up)
    assert cli.main([*SHORT_WALK, "--out", str(tmp_path / "out")]) == 3
    assert capsys.readouterr().err == "linefoot: contact program not solved: infeasible\n"


@pytest.mark.parametrize(
    ("number", "said"), [(signal.SIGINT, "interrupted"), (signal.SIGTERM, "terminated")]
)
def test_interrupt_is_status_130_or_143_and_what_was_simulated_is_written(
    capsys, tmp_path, monkeypatch, number, said
):
    simulate = simulation.simulate

    def interrupted(*args, **options):
        timer = threading.Timer(0.3, os.kill, (os.getpid(), number))
        timer.start()
        try:
            return simulate(*args, **options)
        finally:
            timer.join()

    monkeypatch.setattr(simulation, "simulate", interrupted)
    assert cli.main(["walk", "--out", str(tmp_path / "out")]) == 128 + number
    out, err = capsys.readouterr()
    assert err == f"linefoot: {said}\n"
    assert out.rstrip().endswith(str(tmp_path / "out"))  # there is no replay
    run = Run.load(tmp_path / "out")
    assert 0.0 <= run.time[-1] < run.scenario.duration
    assert not run.fell
    assert json.loads((tmp_path / "out/metrics.json").read_text())["fell"] is False
    assert [path.name for path in tmp_path.iterdir()] == ["out"]
    assert signal.getsignal(number) in {signal.default_int_handler, signal.SIG_DFL}


def test_a_second_interrupt_ends_at_once_and_writes_nothing(capsys, tmp_path, monkeypatch):
    def interrupted_twice(*_, **__):
        os.kill(os.getpid(), signal.SIGINT)
        os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr(simulation, "simulate", interrupted_twice)
    assert cli.main(["walk", "--no-replay", "--out", str(tmp_path / "out")]) == 130
    assert capsys.readouterr().err == "linefoot: interrupted\n"
    assert list(tmp_path.iterdir()) == []


def test_an_error_that_nobody_foresaw_is_status_3_and_what_was_simulated_is_written(
    capsys, tmp_path, monkeypatch
):
    compute, ticks = WholeBodyControl.compute, []

    def fail(*args):
        ticks.append(1)
        if len(ticks) == 60:
            raise IndexError("list index out of range")
        return compute(*args)

    monkeypatch.setattr(WholeBodyControl, "compute", fail)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    assert cli.main([*SHORT_WALK, "--out", str(tmp_path / "out")]) == 3
    out, err = capsys.readouterr()
    assert out.rstrip() == str(tmp_path / "out")
    assert err.startswith("linefoot: unexpected error, IndexError: list index out of range (its ")
    assert err.count("\n") == 1
    kept = Path(re.search(r"traceback is in (\S+)\)", err)[1])
    assert "whole_body_controller.py" in kept.read_text(encoding="utf-8")
    assert 0.05 < Run.load(tmp_path / "out").time[-1] < 0.06


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (ZeroDivisionError("by nothing"), "unexpected error, ZeroDivisionError: by nothing ("),
        (SystemExit("Drake"), "unexpected error, SystemExit: Drake ("),
        (MemoryError(), "unexpected error, MemoryError ("),
        (ValueError("x" * 10**6 + "\n"), f"ValueError: {'x' * 188}... ("),
    ],
)
def test_a_crash_is_no_fall(capsys, tmp_path, monkeypatch, error, said):
    def crash(*_, **__):
        raise error

    monkeypatch.setattr(simulation, "simulate", crash)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    assert cli.main([*SHORT_WALK, "--out", str(tmp_path / "out")]) == 3
    err = capsys.readouterr().err
    assert said in err
    assert err.count("\n") == 1
    (kept,) = tmp_path.glob("*.txt")
    assert f"(its traceback is in {kept})" in err
    assert "in crash" in kept.read_text(encoding="utf-8")


def test_an_interrupt_inside_compiled_code_is_an_interrupt(capsys, tmp_path, monkeypatch):
    def interrupted(*_, **__):
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt as interrupt:
            raise SystemError("returned a result with an exception set") from interrupt

    monkeypatch.setattr(simulation, "simulate", interrupted)
    assert cli.main([*SHORT_WALK, "--out", str(tmp_path / "out")]) == 130
    assert capsys.readouterr().err == "linefoot: interrupted\n"
