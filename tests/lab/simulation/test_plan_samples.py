"""A plan at many times against the plan at each."""

import numpy as np
import pytest

from drake_linefoot.centroidal import sample_plan
from drake_linefoot.lab.simulation.plan_samples import sample_plan_at, write_plans
from drake_linefoot.lab.simulation.recorder import dtype_of
from drake_linefoot.lab.simulation.recording import CHANNELS
from drake_linefoot.layout import Layout, flat
from drake_linefoot.signals import CentroidalPlan
from drake_linefoot.statuses import Solved
from tests.helpers.recorded_runs import SIZES

K = 6
LAYOUT = Layout(CentroidalPlan, {"knots": K})


@pytest.fixture
def plan():
    rng = np.random.default_rng(2)
    return CentroidalPlan(
        times=1.0 + np.cumsum(rng.uniform(0.02, 0.05, K + 1)),
        wrench=rng.normal(size=(K, 2, 5)),
        force=rng.normal(size=(K, 3)),
        moment=rng.normal(size=(K, 3)),
        states=rng.normal(size=(K + 1, 12)),
        r_G=rng.normal(size=3),
        mass=24.0,
        p_WC=rng.normal(size=(K, 2, 3)),
        R_WC=rng.normal(size=(K, 2, 3, 3)),
        coming=0.0,
        footholds=np.zeros((K + 1, 4)),
        external=rng.normal(size=6),
        status=float(Solved.ACTIVE_SET),
        active=2.0,
        iterations=1.0,
        milliseconds=1.0,
        failures=0.0,
    )


def test_a_plan_at_many_times_is_the_plan_at_each(plan):
    """Also at its knots, and beyond its end."""
    middle = 0.5 * (plan.times[1:] + plan.times[:-1])
    t = np.sort([*plan.times, *middle, plan.times[-1] + 0.1])
    many = sample_plan_at(flat(plan), K, t)
    for i, time in enumerate(t.tolist()):
        s = sample_plan(plan, time)
        for name in ("r", "v", "a", "L", "L_dot", "wrench"):
            np.testing.assert_array_equal(getattr(many, name)[i], getattr(s, name), err_msg=name)


def test_the_orientation_is_even_between_two_knots(plan):
    t = np.sort([*(0.25 * plan.times[1:] + 0.75 * plan.times[:-1]), plan.times[-1] + 0.1])
    rows = np.zeros(len(t), dtype_of(CHANNELS, SIZES))
    rows["time"] = t
    write_plans([flat(plan).tobytes()] * len(t), rows, None, LAYOUT)
    eta = plan.states[:, 9:]
    wanted = [*(0.25 * eta[1:] + 0.75 * eta[:-1]), eta[-1]]
    np.testing.assert_allclose(rows["mpc_orientation"], wanted, atol=1e-12)


def test_each_plan_is_written_where_it_holds_and_timed_once(plan):
    """The one before is not new; one that was given, and not solved for, took no time."""
    given = plan._replace(milliseconds=0.0, failures=1.0)
    failed = plan._replace(milliseconds=3.0, failures=2.0, status=float(Solved.INFEASIBLE))
    before, second, third = (flat(each).tobytes() for each in (plan, given, failed))
    rows = np.zeros(7, dtype_of(CHANNELS, SIZES))
    rows["time"] = plan.times[:7]
    write_plans([before] * 2 + [second] * 2 + [third] * 3, rows, before, LAYOUT)
    np.testing.assert_array_equal(rows["mpc_failures"], [0, 0, 1, 1, 2, 2, 2])
    np.testing.assert_array_equal(rows["mpc_success"], [1, 1, 1, 1, 0, 0, 0])
    np.testing.assert_array_equal(rows["mpc_ms"], [*[np.nan] * 4, 3.0, np.nan, np.nan])
    for k in range(6):
        np.testing.assert_array_equal(rows["mpc_wrench"][k], plan.wrench[k])
