"""A plan at many times against the plan at each."""

import numpy as np
import pytest

from drake_linefoot.signals import CentroidalPlan, SolverReport
from drake_linefoot.simulation.plan_samples import sample_plan_at


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
    for axis in range(3):
        between = np.interp(t, plan.times, plan.states[:, 9 + axis])
        np.testing.assert_allclose(many.eta[:, axis], between, atol=1e-12)
