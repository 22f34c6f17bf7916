"""Replays of a sweep are drawn by processes of their own."""

import sys

import pytest

from drake_linefoot.lab.results.judge import state_hash
from drake_linefoot.lab.sweep.file import load_sweep
from drake_linefoot.lab.sweep.jobs import job
from drake_linefoot.lab.sweep.replays import file_of, write_replays
from drake_linefoot.lab.sweep.rows import key_of
from drake_linefoot.lab.sweep.worker import simulated
from drake_linefoot.lab.visualization import replay, view
from tests.helpers.tiny_sweeps import made_up_row, write_sweep


@pytest.fixture
def sweep(tmp_path):
    return load_sweep(write_sweep(tmp_path, runs=1))


def test_a_replay_is_drawn_without_a_port_in_this_process(sweep, tmp_path, monkeypatch):
    monkeypatch.setattr(view, "Meshcat", None)
    came_to = state_hash(simulated(job(sweep, sweep.groups[0], 0).scenario))
    rows, said = [made_up_row(state_hash=came_to)], []
    assert write_replays(sweep, rows, tmp_path, said.append) == {key_of(rows[0]): file_of(rows[0])}
    assert said == []
    page = (tmp_path / file_of(rows[0])).read_text(encoding="utf-8")
    assert "<title>low 0, drake_linefoot " in page[:2000]
    assert write_replays(sweep, [made_up_row(state_hash="0" * 16)], tmp_path, said.append)
    assert len(said) == 1 and "the replay of run 0 of low differs" in said[0]
    assert len(list((tmp_path / "replays").iterdir())) == 1  # that of before is removed


def test_a_process_that_dies_costs_its_replay_alone(sweep, tmp_path, monkeypatch):
    dying = (sys.executable, "-c", "import os; os.abort()")
    monkeypatch.setattr(replay, "PROGRAM", dying)
    rows, said = [made_up_row(group="low"), made_up_row(group="high")], []
    assert write_replays(sweep, rows, tmp_path, said.append) == {}
    missing = [line for line in said if "is missing" in line]
    assert len(missing) == 2
    assert "the replay of run 0 of low is missing: " in missing[0] and "SIGABRT" in missing[0]
    assert list((tmp_path / "replays").iterdir()) == []
