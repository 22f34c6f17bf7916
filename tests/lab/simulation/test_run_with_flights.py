"""The MIT Humanoid runs: what physics says of its flights, by Drake's plant, and the contacts."""

import numpy as np
import pytest

from drake_linefoot.lab.scenario.load import make_scenario
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.robot.humanoid import load_humanoid

pytestmark = pytest.mark.slow
LATE = 0.004  # [s] at most after the ground is met a foot stands


@pytest.fixture(scope="module")
def run():
    """From rest to 1.8 m/s and back: it walks, runs, walks and stands."""
    segments = [
        {"name": "go", "duration": 4.5, "walk": True, "velocity": [1.8, 0.0]},
        {"name": "slow", "duration": 2.5, "walk": True},
        {"name": "stand", "duration": 1.0},
    ]
    return simulate(build_closed_loop(make_scenario({"segments": segments}, "a run")))


@pytest.fixture(scope="module")
def flights(run):
    """First and last sample of each time in which no foot is on the ground, but the shortest."""
    air = ~(run.true_normal.sum(axis=2) > 0.0).any(axis=1)
    change = np.flatnonzero(np.diff(np.r_[False, air, False].astype(int)))
    pairs = change.reshape(-1, 2)
    return [(a, b - 1) for a, b in pairs if run.time[b - 1] - run.time[a] > 0.02]


def test_it_runs_as_told_and_stands(run, flights):
    assert not run.fell
    fast = (run.time > 3.7) & (run.time < 4.5)
    speed = np.polyfit(run.time[fast], run.com[fast, 0], 1)[0]
    assert speed == pytest.approx(1.8, abs=0.09)
    assert np.abs(run.rpy[:, :2]).max() < 0.15
    times = [run.time[b] - run.time[a] for a, b in flights if run.time[a] > 2.5]
    assert len(times) > 8
    assert np.median(times) > 0.04
    assert run.planned_contact[-1].all()
    assert np.abs(run.v[-1]).max() < 0.05


def test_momentum_is_conserved_in_flights_and_the_com_falls(run, flights):
    plant = load_humanoid("mit_humanoid").plant
    context = plant.CreateDefaultContext()
    for a, b in flights[3::4]:
        L = []
        for i in (a + 2, b - 1):
            plant.SetPositionsAndVelocities(context, np.concatenate([run.q[i], run.v[i]]))
            momentum = plant.CalcSpatialMomentumInWorldAboutPoint(context, run.com[i])
            L.append(momentum.rotational())
        np.testing.assert_allclose(L[1], L[0], atol=0.05)
        t = run.time[a : b + 1]
        fall = np.polyfit(t - t[0], run.com[a : b + 1], 2)[0]
        np.testing.assert_allclose(2.0 * fall, [0.0, 0.0, -9.81], atol=0.1)


def test_contacts_are_those_of_the_plan(run, flights):
    """Free fall is no contact to the estimator, and a foot stands soon after it should land."""
    for a, b in flights:
        assert not run.contact_flag[a + 12 : b].any()
    up, plan = run.true_normal.sum(axis=2) > 0.0, run.planned_contact > 0.5
    for a, b in flights:
        foot = int(np.argmax(up[min(b + 1, len(up) - 1)]))
        stands = np.flatnonzero(plan[a:, foot])[0] + a
        assert run.time[stands] - run.time[b] <= LATE
    assert run.gait_steps[-1] > 20
