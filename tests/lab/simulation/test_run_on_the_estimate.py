"""The MIT Humanoid runs on the estimate of its state: what the estimate is held against is true."""

import numpy as np
import pytest

from drake_linefoot.lab.scenario.load import make_scenario
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop

pytestmark = pytest.mark.slow
FORGOTTEN = 25  # [ticks] after which nothing of a force is left in the estimate


@pytest.fixture(scope="module")
def run():
    """From rest to 1.5 m/s and back: it walks, runs, walks and stands."""
    segments = [
        {"name": "rest", "duration": 0.6},
        {"name": "go", "duration": 4.4, "walk": True, "velocity": [1.5, 0.0]},
        {"name": "slow", "duration": 2.4, "walk": True},
        {"name": "stand", "duration": 1.5},
    ]
    scenario = {"estimation": True, "segments": segments}
    return simulate(build_closed_loop(make_scenario(scenario, "a run on the estimate")))


def test_it_runs_as_told_and_stands(run):
    assert not run.fell, run.fall_reason
    fast = (run.time > 4.0) & (run.time < 5.0)  # a second after it began to run
    speed = np.polyfit(run.time[fast], run.com[fast, 0], 1)[0]
    assert speed == pytest.approx(1.5, abs=0.05)
    flies = ~(run.true_normal.sum(axis=2) > 0.0).any(axis=1)
    assert flies[fast].mean() > 0.2
    assert np.abs(run.rpy[:, :2]).max() < 0.15
    assert run.planned_contact[-1].all()
    last = run.time > run.time[-1] - 0.5  # it stands on an estimate, so its joints tremble a little
    assert np.sqrt(np.mean(run.v[last] ** 2, axis=0)).max() < 0.05


def test_the_estimate_flies_as_the_robot_does(run):
    error = (run.estimate_velocity - run.v[:, :6])[run.time > 0.6, 3:]
    assert np.sqrt(np.mean(error**2, axis=0)).max() < 0.01


def test_no_contact_is_seen_where_there_is_none(run):
    """Of a foot that the ground has not pressed on for a while, whatever the other one does."""
    up = run.true_normal.sum(axis=2) > 0.0
    for foot in range(2):
        since = np.arange(len(up)) - np.maximum.accumulate(
            np.where(up[:, foot], np.arange(len(up)), 0)
        )
        air = since > FORGOTTEN
        assert air.sum() > 500
        assert not run.contact_flag[air, foot].any()
        assert np.abs(run.contact_wrench[air, foot, 2]).max() < 12.0  # below `release_force`
