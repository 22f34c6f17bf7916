"""Nothing is computed twice in a tick of the closed loop."""

from collections import Counter

import pytest

from drake_linefoot.estimation import contact_estimator
from drake_linefoot.gait import gait_planner
from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.scenario.disturbances import SensorParameters
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.mpc.reference import ReferenceGenerator
from drake_linefoot.mpc.solve import MpcSolver
from drake_linefoot.robot import state_dynamics
from drake_linefoot.wbc.control import WholeBodyControl

TICKS = 400


@pytest.fixture
def counts(monkeypatch):
    """How often each piece of work is done."""
    counter = Counter()
    for owner, name in (
        (state_dynamics, "dynamics_vector"),
        (contact_estimator, "next_estimate"),
        (gait_planner, "update"),
        (gait_planner, "present_targets"),
        (gait_planner, "horizon_vector"),
        (ReferenceGenerator, "vector"),
        (MpcSolver, "solve"),
        (WholeBodyControl, "compute"),
    ):
        monkeypatch.setattr(owner, name, counted(getattr(owner, name), name, counter))
    return counter


def counted(work, name, counter):
    """Return `work` that counts its calls."""

    def call(*args, **kwargs):
        counter[name] += 1
        return work(*args, **kwargs)

    return call


@pytest.mark.parametrize("noise", [False, True])
def test_every_block_computes_once_per_period(counts, noise):
    """With noise the dynamics are those of two states, the measured and the true one."""
    scenario = Scenario(
        segments=[Segment("stand", 0.1), Segment("walk", 2.0, walk=True, velocity=[0.4, 0.0])],
        sensors=SensorParameters(gyro=1e-3) if noise else SensorParameters(),
    )
    simulator = build_closed_loop(scenario).make_simulator()
    simulator.Initialize()
    simulator.AdvanceTo(0.4005)  # in the first steps; between two ticks
    counts.clear()
    simulator.AdvanceTo(0.4005 + 1e-3 * TICKS)
    updates = TICKS // 20
    expected = dict.fromkeys(("next_estimate", "update", "present_targets", "compute"), TICKS)
    expected |= dict.fromkeys(("horizon_vector", "vector", "solve"), updates)
    expected["dynamics_vector"] = 2 * TICKS if noise else TICKS
    assert counts == expected
