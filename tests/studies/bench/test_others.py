"""Loops in processes of their own: with this environment, and with what is none."""

import platform
import sys
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest

from drake_linefoot.errors import LinefootError
from studies.bench import others
from studies.bench.loops import LoopChunks, PlantStep, sweep_run
from studies.bench.measures import Results
from tests.helpers.tiny_sweeps import write_sweep
from tests.helpers.walked import LEAST, walk


@pytest.fixture
def states():
    return walk().walking_states(2)


@pytest.fixture
def short(tmp_path, monkeypatch):
    """A sweep of short runs takes the place of the nominal one."""
    file = write_sweep(tmp_path)
    monkeypatch.setattr(others, "SWEEP", file)
    return file


@pytest.mark.slow
def test_two_environments_take_turns(states, short):
    results = Results()
    others.against(walk(), states, Path(sys.executable), LEAST, results)
    assert results.rest["against"] == {
        "python": platform.python_version(),
        "drake_linefoot": version("drake_linefoot"),
        "drake": version("drake"),
        "numpy": np.__version__,
    }
    assert set(results.values) == set(others.AGAINST)
    assert min(results.values.values()) > 0.0
    counts = {name: summary.n for name, summary in results.times.items()}
    one_each = ("own_loop", "other_loop", "own_sweep_run", "other_sweep_run")
    assert counts == {"own_plant_step": 2, "other_plant_step": 2} | dict.fromkeys(one_each, 1)


@pytest.mark.slow
def test_a_worker_walks_on_until_it_is_not_needed(states):
    with others.LoopWorker(Path(sys.executable), walk(), states) as worker:
        assert len(worker.times(loop=2)) == 2
        with worker.walking():
            assert worker._process.poll() is None
    assert worker._process.poll() is not None


@pytest.mark.slow
def test_another_interpreter_has_its_own_package_whatever_path_this_one_has(
    states, tmp_path, monkeypatch
):
    (tmp_path / "drake_linefoot.py").write_text("raise ImportError('of the path')", "utf-8")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    another = tmp_path / "python"
    another.write_text(f'#!/bin/sh\nexec "{sys.executable}" "$@"\n', encoding="utf-8")
    another.chmod(0o755)
    with others.LoopWorker(another, walk(), states) as worker:
        assert worker.times(loop=1)
    with pytest.raises(LinefootError, match="of the path"):
        others.LoopWorker(Path(sys.executable), walk(), states)


@pytest.mark.slow
def test_a_worker_that_comes_to_an_error_says_which(states, monkeypatch):
    monkeypatch.setattr(others, "SWEEP", Path("no/such.yaml"))
    with (
        others.LoopWorker(Path(sys.executable), walk(), states) as worker,
        pytest.raises(LinefootError, match=r"no/such\.yaml"),
    ):
        worker.sweep_run()


def test_what_is_no_interpreter_and_what_lacks_the_package_is_said(states):
    with pytest.raises(LinefootError, match="no/such/python: No such file"):
        others.LoopWorker(Path("no/such/python"), walk(), states)
    with pytest.raises(LinefootError, match="false: no answer"):
        others.LoopWorker(Path("/bin/false"), walk(), states)


def test_a_robot_that_falls_is_not_timed(states, monkeypatch):
    monkeypatch.setattr(others.LoopWorker, "__init__", lambda *_: None)
    monkeypatch.setattr(others.LoopWorker, "_name", "python", raising=False)
    monkeypatch.setattr(
        others.LoopWorker, "ask", lambda *_: {"times": [1.0], "fell": "the torso is low"}
    )
    with pytest.raises(LinefootError, match="python: the robot fell: the torso is low"):
        others.LoopWorker(Path(sys.executable), walk(), states).times(loop=1)


def test_a_run_of_a_sweep_takes_time_and_an_error_is_raised(short, monkeypatch):
    assert sweep_run(str(short), 1) > 0.0
    with monkeypatch.context() as patch:
        patch.setattr("drake_linefoot.lab.sweep.worker.simulated", lambda _: 1 / 0)
        with pytest.raises(RuntimeError, match=r"run 0 of .*ZeroDivisionError"):
            sweep_run(str(short), 0)


def test_steps_start_from_the_states_that_are_given(states):
    plant = PlantStep(walk().humanoid, walk().scenario)
    assert len(plant.batch(states)) == len(plant.cold(states)) == 2
    context = plant._plant.GetMyContextFromRoot(plant._simulator.get_context())
    q = plant._plant.GetPositions(context)
    step = np.abs(q - states[-1][0][: len(q)]).max()
    assert 0.0 < step < 0.01  # of a step of 1 ms


def test_the_loop_walks_a_chunk_at_a_time():
    loop = LoopChunks(walk().scenario)
    before = loop._simulator.get_context().get_time()
    assert len(loop.batch(2)) == 2
    assert loop._simulator.get_context().get_time() == pytest.approx(before + 0.08)
    assert loop.fell() == ""
