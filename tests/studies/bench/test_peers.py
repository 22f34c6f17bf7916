"""A peer that is not there leaves a note, and the rest goes on."""

import sys
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drake_linefoot.errors import LinefootError
from studies.bench import peers, placo_peer, solvers
from studies.bench.measures import Results
from tests.helpers.walked import walk


@pytest.fixture
def placo_python():
    """An interpreter that has PlaCo, or the test is skipped."""
    python = placo_peer.interpreter(None)
    ticks = walk().walking_ticks(1)
    try:
        with placo_peer.PlacoPeer(python, walk().humanoid, walk().scenario, ticks):
            return python
    except LinefootError as error:
        pytest.skip(f"needs PlaCo: {error}")


def missing(name):
    def prepare(qp, tolerance):
        raise ImportError(f"No module named '{name}'")

    return prepare


def test_missing_solver_is_noted_and_the_others_are_there(monkeypatch):
    found = {
        "osqp": solvers.SOLVERS["osqp"],
        "daqp": replace(solvers.SOLVERS["daqp"], prepare=missing("daqp")),
    }
    monkeypatch.setattr(peers, "SOLVERS", found)
    results = Results()
    batches = peers.solver_batches(walk(), 2, results)
    assert list(batches) == ["solve_osqp"]
    assert "No module named 'daqp'" in results.notes["solve_daqp"]
    assert len(batches["solve_osqp"]()) == 2


def test_without_mujoco_there_is_a_note(monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    results = Results()
    assert peers.mujoco(walk(), results) is None
    assert "drake_linefoot[bench]" in results.notes["mujoco_step"] and not results.peers


def test_mujoco_simulates_the_same_robot():
    pytest.importorskip("mujoco")
    results, ticks = Results(), walk().walking_ticks(3)
    peer = peers.mujoco(walk(), results)
    for tick in ticks:
        assert peer.mass_matrix_difference(tick.before.x) < 1e-12
    assert results.peers["mujoco"]["mass_matrix_difference"] < 1e-12
    assert min(peer.batch(ticks)) > 0.0


def test_inaccurate_solver_is_noted_and_not_timed(monkeypatch):
    def zero(qp, tolerance):
        return lambda: np.zeros(len(qp.g))

    monkeypatch.setattr(peers, "SOLVERS", {"osqp": replace(solvers.SOLVERS["osqp"], prepare=zero)})
    results = Results()
    assert peers.solver_batches(walk(), 2, results) == {}
    assert "in the first wrench at its best" in results.notes["solve_osqp"]
    assert results.peers["osqp"]["tolerance"] is None


def test_accuracy_of_the_shipped_solver_is_told():
    results = Results()
    peers.solver_batches(walk(), 2, results)
    assert results.peers["shipped"]["first_wrench_error_n"] < 1.0


@pytest.mark.parametrize("python", ["no/such/python", "/bin/false"])
def test_missing_placo_is_noted_with_what_to_do(python):
    results = Results()
    with ExitStack() as stack:
        assert peers.placo(walk(), 1, Path(python), results, stack) is None
    assert "placo==0.10" in results.notes["wbc_tick_over_placo"]
    assert "placo" not in results.peers


def test_placo_does_the_same_job(placo_python):
    ticks = walk().walking_ticks(4)
    with placo_peer.PlacoPeer(placo_python, walk().humanoid, walk().scenario, ticks) as peer:
        assert peer.version.startswith("0.10")
        assert peer.force_difference < 5.0  # [N]
        assert len(peer.batch()) == 4
