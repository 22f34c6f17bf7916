"""A plan at many times against the plan at each."""

import numpy as np
import pytest

from drake_linefoot.signals import CentroidalPlan, SolverReport
from drake_linefoot.simulation.plan_samples import sample_plan_at, write_plans
from drake_linefoot.simulation.recording import CHANNELS
from drake_linefoot.simulation.ticks import dtype_of
from tests.helpers.recorded_runs import SIZES


@pytest.fixture
def plan():
    rng, K = np.random.default_rng(2), 6
    return CentroidalPlan(
        times=1.0 + np.cumsum(rng.uniform(0.02, 0.05, K + 1)),
        wrench=rng.normal(size=(K, 2, 5)),
        states=rng.normal(size=(K + 1, 12)),
        r_G=rng.normal(size=3),
        mass=24.0,
        p_WC=rng.normal(size=(K, 2, 3)),
        R_WC=rng.normal(size=(K, 2, 3, 3)),
        footholds=np.zeros((0, 4)),
        external=rng.normal(size=6),
        report=SolverReport(True, "", 1, 1.0),
        failures=0,
    )


def test_a_plan_at_many_times_is_the_plan_at_each(plan):
    """Also at its knots, and beyond its end."""
    middle = 0.5 * (plan.times[1:] + plan.times[:-1])
    t = np.sort([*plan.times, *middle, plan.times[-1] + 0.1])
    many = sample_plan_at(plan.trajectory, t)
    for i, time in enumerate(t.tolist()):
        s = plan.sample(time)
        for name in ("r", "v", "a", "L", "L_dot", "wrench"):
            np.testing.assert_array_equal(getattr(many, name)[i], getattr(s, name), err_msg=name)


def test_the_orientation_is_even_between_two_knots(plan):
    t = np.sort([*(0.25 * plan.times[1:] + 0.75 * plan.times[:-1]), plan.times[-1] + 0.1])
    rows = np.zeros(len(t), dtype_of(CHANNELS, SIZES))
    rows["time"] = t
    write_plans([plan] * len(t), rows, None)
    eta = plan.states[:, 9:]
    wanted = [*(0.25 * eta[1:] + 0.75 * eta[:-1]), eta[-1]]
    np.testing.assert_allclose(rows["mpc_orientation"], wanted, atol=1e-12)
