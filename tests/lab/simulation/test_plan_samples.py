"""A plan at many times against the plan at each."""

import numpy as np
import pytest

from drake_linefoot.centroidal import sample_plan
from drake_linefoot.lab.simulation.plan_samples import sample_plans
from drake_linefoot.lab.simulation.recorder import dtype_of, rows_of
from drake_linefoot.lab.simulation.recording import CHANNELS
from drake_linefoot.layout import Layout, flat
from drake_linefoot.signals import CentroidalPlan
from drake_linefoot.statuses import Solved
from tests.helpers.recorded_runs import SIZES

K = 6
LAYOUT = Layout(CentroidalPlan, {"knots": K, "nw": 5})


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


def sampled(plans, times, before=None):
    """The plans of ticks, and what is recorded of them."""
    records = np.frombuffer(np.concatenate([flat(plan) for plan in plans]), LAYOUT.dtype)
    before = None if before is None else flat(before)
    samples = sample_plans(records, times, LAYOUT, before)
    signals = {"time": times, "plan": records, "plan_sample": samples}
    return rows_of(signals, dtype_of(CHANNELS, SIZES))


def test_a_plan_at_many_times_is_the_plan_at_each(plan):
    """Also at its knots, and beyond its end."""
    middle = 0.5 * (plan.times[1:] + plan.times[:-1])
    t = np.sort([*plan.times, *middle, plan.times[-1] + 0.1])
    rows = sampled([plan] * len(t), t)
    of = {
        "mpc_com": "r", "mpc_velocity": "v", "mpc_acceleration": "a", "mpc_momentum": "L",
        "mpc_momentum_rate": "L_dot", "mpc_wrench": "wrench",
    }  # fmt: skip
    for row, time in zip(rows, t.tolist(), strict=True):
        sample = sample_plan(plan, time)
        for channel, name in of.items():
            np.testing.assert_array_equal(row[channel], getattr(sample, name), err_msg=name)


def test_the_orientation_is_even_between_two_knots(plan):
    t = np.sort([*(0.25 * plan.times[1:] + 0.75 * plan.times[:-1]), plan.times[-1] + 0.1])
    eta = plan.states[:, 9:]
    wanted = [*(0.25 * eta[1:] + 0.75 * eta[:-1]), eta[-1]]
    found = sampled([plan] * len(t), t)["mpc_orientation"]
    np.testing.assert_allclose(found, wanted, atol=1e-12)


def test_each_plan_is_written_where_it_holds_and_timed_once(plan):
    """The one before is not new; one that was given, and not solved for, took no time."""
    given = plan._replace(milliseconds=0.0, failures=1.0)
    failed = plan._replace(milliseconds=3.0, failures=2.0, status=float(Solved.INFEASIBLE))
    plans = [plan] * 2 + [given] * 2 + [failed] * 3
    rows = sampled(plans, plan.times[:7], before=plan)
    np.testing.assert_array_equal(rows["mpc_failures"], [0, 0, 1, 1, 2, 2, 2])
    np.testing.assert_array_equal(rows["mpc_success"], [1, 1, 1, 1, 0, 0, 0])
    np.testing.assert_array_equal(rows["mpc_ms"], [*[np.nan] * 4, 3.0, np.nan, np.nan])
    np.testing.assert_array_equal(sampled(plans, plan.times[:7])["mpc_ms"][:2], [1.0, np.nan])
    for k in range(6):
        np.testing.assert_array_equal(rows["mpc_wrench"][k], plan.wrench[k])
