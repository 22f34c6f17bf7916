"""Figures 3 to 7 and the feasibility of plans, on runs with known answers."""

import json
from dataclasses import replace

import numpy as np
import pytest

from drake_linefoot.centroidal import PlanSample
from drake_linefoot.constants import GRAVITY
from drake_linefoot.estimation.contact_parameters import EstimatorParameters
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.robot.dynamics import robot_dynamics
from drake_linefoot.robot.humanoid import load_humanoid
from drake_linefoot.wbc.control import WholeBodyControl
from drake_linefoot.wbc.parameters import WbcParameters
from studies.common import runs
from studies.paper import feasibility, fig3, fig4, fig5, fig6, fig7
from tests.helpers.feet import feet_of
from tests.helpers.made_up import PERIOD, age, circle, walk
from tests.helpers.recorded_runs import SHORT, short_run

N = 2001


def saved(data):
    """Data as it comes back from its file."""
    return json.loads(json.dumps(data, allow_nan=False))


def check_shown(module, data):
    """Picture and table of a figure; returns what the picture says."""
    data = saved(data)
    figure = module.draw(data)
    assert all(ax.get_ylabel() or ax.get_title() for ax in figure.axes)
    rows = module.table(data)
    assert {len(row) for row in rows} == {len(rows[0])}
    assert all(isinstance(cell, str) for row in rows for cell in row)
    return figure.get_suptitle()


# ------------------------------------------------------------------------------- figure 3


def walk_on_a_circle(speed=0.5, turn=0.8, commanded=0.5):
    time = np.arange(N) * 1e-3
    p, v, quaternion = circle(time, speed, turn)
    q = np.zeros((N, 25))
    q[:, :4], q[:, 4:7] = quaternion, p
    run = walk(q=q, com=p, mpc_mean_velocity=v)
    run.scenario.segments[0].velocity = [commanded, 0.0]
    run.scenario.segments[0].turn_rate = turn
    return run


def test_velocity_that_is_commanded_is_close():
    data = saved(fig3.measure(walk_on_a_circle()))
    (row,) = data["rows"]
    assert row["resulting"] == pytest.approx([0.5, 0.0, 0.8], abs=1e-3)
    assert row["planned"] == pytest.approx([0.5, 0.0], abs=0.01)
    assert [claim.holds for claim in fig3.claims(data)] == [True, True]
    assert "FELL" not in check_shown(fig3, data)


def test_velocity_that_is_not_commanded_is_told_with_its_error():
    data = saved(fig3.measure(walk_on_a_circle(commanded=0.8)))
    planned, resulting = fig3.claims(data)
    assert not planned.holds
    assert not resulting.holds
    assert resulting.ours == "at most 0.300 off, 0.080 allowed"


def test_a_run_that_ended_early_is_not_called_close():
    run = replace(walk_on_a_circle(), fell=True, fall_time=2.0, fall_reason="torso low")
    run.scenario.segments[0].duration = 3.0
    data = saved(fig3.measure(run))
    assert not fig3.claims(data)[1].holds
    assert "the robot FELL at 2.00 s: torso low" in check_shown(fig3, data)


# ------------------------------------------------------------------------------- figure 4


def rolling(amplitude, **changes):
    """A walk whose torso rolls to and fro."""
    roll = amplitude * np.sin(2.0 * np.pi * np.arange(N) / 200.0)
    q = np.zeros((N, 25))
    q[:, 0], q[:, 1] = np.cos(0.5 * roll), np.sin(0.5 * roll)
    return replace(walk(q=q), **changes)


def both(ecd, srbm, beyond=None):
    """Figure 4 of two models; the contact-consistent one does as the ECD unless given."""
    shown = {"ecd": ecd, "srbm": srbm, "contact_consistent": beyond or ecd}
    rows = [
        {"walk": "paper", "seed": 0, "model": name, **fig4.judge(run)}
        for name, run in shown.items()
    ]
    return saved(fig4.assemble(shown, rows))


def test_ratio_is_that_of_the_root_mean_squares():
    data = both(rolling(0.01), rolling(0.04))
    assert data["ratios"]["roll_rms_ecd_over_srbm"] == pytest.approx(0.25, rel=1e-3)
    assert data["ratios"]["pitch_rms_ecd_over_srbm"] is None  # nothing pitches
    follows, leaves, roll, roll_beyond, pitch, *_ = fig4.claims(data)
    assert (follows.holds, leaves.holds, roll.holds, pitch.holds) == (True, False, True, False)
    assert roll.ours == "RMS 0.25 times the base's"
    assert (roll_beyond.holds, roll_beyond.ours) == (False, "RMS 1.00 times the ECD's")
    check_shown(fig4, data)


def test_forecasts_are_compared_with_what_came():
    """The ECD foresees all of the roll's change here, the base half of it."""
    right, wrong = rolling(0.01), rolling(0.01)
    right.mpc_orientation[:, 0] = right.rpy[:, 0]
    wrong.mpc_orientation[:, 0] = 0.5 * wrong.rpy[:, 0]
    assert fig4.forecast_error(right) == pytest.approx(0.0, abs=1e-6)
    assert fig4.forecast_error(wrong) == pytest.approx(0.5, abs=1e-6)
    assert fig4.forecast_slopes(wrong)[0] == pytest.approx(0.5)
    assert np.isnan(fig4.forecast_slopes(wrong)[1])  # nothing pitches
    data = both(right, wrong, wrong)
    assert data["forecast_contact_consistent"] == pytest.approx(0.5)
    assert not fig4.claims(data)[-1].holds
    assert fig4.claims(both(wrong, wrong, right))[-1].holds
    claim = fig4.claims(both(right, wrong))[-2]
    assert "foresees 1.00 and - times as much" in claim.note
    assert (claim.holds, claim.ours) == (True, "forecast off by 0 %, the base's by 50 %")
    assert not fig4.claims(both(wrong, right))[-2].holds
    assert not any(c.holds for c in fig4.claims(both(walk(), walk()))[-2:])  # nothing moves


def test_the_torso_that_turns_off_its_command_does_not_follow():
    turned = rolling(0.01)
    turned.q[:, :4] = 0.0
    turned.q[:, 0], turned.q[:, 3] = np.cos(0.05), np.sin(0.05)  # yaw of 0.1 rad
    data = both(turned, turned)
    assert data["rows"][0]["yaw_rms"] == pytest.approx(0.1)
    assert not fig4.claims(data)[0].holds


def test_the_base_leaves_the_limits_only_where_the_ecd_stays_in_them():
    data = both(rolling(0.01), rolling(0.01))
    fast = [
        {**row, "walk": "fast", "roll_max": 0.5 if row["model"] == "srbm" else 0.01}
        for row in data["rows"]
    ]
    assert fig4.claims({**data, "rows": data["rows"] + fast})[1].holds
    both_leave = [{**row, "roll_max": 0.5} for row in fast]
    assert not fig4.claims({**data, "rows": data["rows"] + both_leave})[1].holds


def test_a_base_that_falls_is_told_in_the_picture_and_is_no_fall_of_ours():
    base = rolling(0.8, fell=True, fall_time=1.5, fall_reason="torso low")
    data = both(rolling(0.01), base)
    assert data["fell"] is False
    assert fig4.claims(data)[1].holds
    assert "Base MPC FELL at 1.50 s: torso low" in check_shown(fig4, data)


def test_a_fall_of_ours_is_told():
    ours = rolling(0.01, fell=True, fall_time=1.0, fall_reason="torso low")
    data = both(ours, rolling(0.01))
    assert data["fell"] is True
    assert not fig4.claims(data)[0].holds
    assert "the robot FELL at 1.00 s" in check_shown(fig4, data)


# ------------------------------------------------------------------------------- figure 5


def with_force_error(size):
    error = np.zeros((N, 2, 5))
    error[:, 0, 2] = size
    return walk(wrench_error=error)


def test_an_error_that_vanishes_with_every_update():
    data = saved(fig5.measure(with_force_error(0.1 * age(N))))
    assert data["after_update"] == {"median": 0.0, "p95": 0.0, "max": 0.0}
    assert data["before_update"]["median"] == pytest.approx(0.1 * (PERIOD - 1))
    assert data["zero_after"] == 1.0
    ages = [row["median"] for row in data["force_by_age"]]
    assert ages == pytest.approx([0.1 * k for k in range(PERIOD)])
    vanishes, perfect = fig5.claims(data)
    assert vanishes.holds
    assert vanishes.ours.startswith("100.0 % of 101 updates, and of the ticks before them 0.0 %; ")
    assert "95th percentile 1.900 N before" in vanishes.ours
    assert not perfect.holds  # 0.95 N in the median
    check_shown(fig5, data)


def test_an_error_that_stays():
    vanishes, perfect = fig5.claims(saved(fig5.measure(with_force_error(1.0))))
    assert not vanishes.holds
    assert not perfect.holds


def test_forces_and_torques_are_told_apart():
    error = np.zeros((N, 2, 5))
    error[:, 0, :3], error[:, 1, 3:] = [0.0, 3.0, 4.0], [0.6, 0.8]
    force, torque = fig5.error_norms(walk(wrench_error=error))
    np.testing.assert_allclose(force, 5.0)
    np.testing.assert_allclose(torque, 1.0)


def test_a_robot_that_never_walks_vanishes_nothing():
    data = saved(fig5.measure(walk(mode=np.zeros(N))))
    assert data["zero_after"] is None
    assert not any(claim.holds for claim in fig5.claims(data))
    check_shown(fig5, data)


# ------------------------------------------------------------------------------- figure 6


def test_landing_is_the_beginning_of_a_stance():
    planned = np.repeat([1.0, 0.0, 1.0], [5, 5, 10])
    np.testing.assert_array_equal(np.flatnonzero(fig6.landing(planned, 3)), [10, 11, 12])


def test_normal_forces_are_compared_where_a_foot_stands():
    mpc, wbc, true = np.zeros((N, 2, 5)), np.zeros((N, 2, 5)), np.zeros((N, 2, 3))
    mpc[:, :, 2], wbc[:, :, 2], true[:, :, 2] = 120.0, 121.0, 124.0
    contact = np.ones((N, 2))
    contact[:1000, 1] = 0.0  # the right foot lands in the middle
    true[1001:1021, 1, 2] = 320.0
    run = walk(mpc_wrench=mpc, wbc_wrench=wbc, true_force=true, planned_contact=contact)
    data = saved(fig6.measure(run))
    rows = {(row["foot"], row["part"]): row for row in data["rows"]}
    assert rows["left foot", "standing"]["wbc_mpc"] == pytest.approx(1.0)
    assert rows["right foot", "standing"]["true_mpc"] == pytest.approx(4.0)
    assert rows["right foot", "landing"]["true_mpc"] == pytest.approx(200.0)
    assert rows["left foot", "landing"]["ticks"] == 0
    desired, everything, standing = fig6.claims(data)
    assert (desired.holds, desired.ours) == (True, "RMS 1.00 N")
    assert not everything.holds  # with the landing
    assert (standing.holds, standing.ours) == (True, "RMS 4.00 N")
    assert "is 200.0 N" in standing.note
    check_shown(fig6, data)


# ------------------------------------------------------------------------------- figure 7


@pytest.mark.parametrize(("share", "holds"), [(0.1, True), (0.5, False)])
def test_a_plan_is_judged_by_what_changed_while_it_was_used(share, holds):
    time = np.arange(N) * 1e-3
    moving = np.outer(time, [0.5, 0.0, 0.0])
    drift = np.zeros((N, 3))
    drift[:, 0] = share * 0.5e-3 * age(N)
    measured = {name: moving for name in ("r", "v", "L")}
    planned = {
        "mpc_com": moving + drift,
        "mpc_velocity": moving + drift,
        "mpc_momentum": moving + drift,
    }
    data = saved(fig7.measure(walk(**planned), measured))
    assert [row["share"] for row in data["rows"]] == pytest.approx([share] * 3)
    assert [row["share_p95"] for row in data["rows"]] == pytest.approx([share] * 3)
    assert [claim.holds for claim in fig7.claims(data)] == [holds, holds]
    check_shown(fig7, data)


# ---------------------------------------------------------------------------- feasibility


def exact_plan(dynamics, wrench, mass):
    """The plan of a model that is right: momentum rates that the wrenches cause."""
    moment = np.zeros(3)
    for foot, w in zip(feet_of(dynamics), wrench, strict=True):
        moment += np.cross(foot.p_WC - dynamics.p_WG, w[:3]) + foot.R_WC[:, 1:] @ w[3:]
    a = GRAVITY + wrench[:, :3].sum(axis=0) / mass
    zero = np.zeros(3)
    return PlanSample(zero, zero, a, zero, moment, wrench)


@pytest.fixture(scope="module")
def moving():
    humanoid = load_humanoid("mit_humanoid")
    run = short_run()
    x = np.concatenate([run.q[-1], run.v[-1]])
    gains = WholeBodyControl(humanoid, WbcParameters()).constants.gains
    return humanoid, robot_dynamics(humanoid, humanoid.plant.CreateDefaultContext(), x), gains


@pytest.mark.parametrize("sides", [[0], [1], [0, 1]])
def test_a_right_plan_leaves_nothing(moving, sides):
    humanoid, dynamics, gains = moving
    wrench = np.zeros((2, 5))
    wrench[sides] = np.array([12.0, -7.0, 150.0, 3.0, 1.0])
    plan = exact_plan(dynamics, wrench, humanoid.mass)
    left, dropped = feasibility.plan_residual(dynamics, plan, sides, humanoid.mass, gains)
    np.testing.assert_allclose(left, 0.0, atol=1e-8)
    assert dropped == 0


def test_what_a_plan_gets_wrong_is_what_is_left(moving):
    humanoid, dynamics, gains = moving
    wrench = np.tile([5.0, 2.0, 120.0, 1.0, 0.5], (2, 1))
    plan = exact_plan(dynamics, wrench, humanoid.mass)
    off = np.array([1.0, -2.0, 3.0])
    wrong = plan._replace(a=plan.a + off, L_dot=plan.L_dot - off)
    left, _ = feasibility.plan_residual(dynamics, wrong, [0, 1], humanoid.mass, gains)
    np.testing.assert_allclose(left[:3], humanoid.mass * off, atol=1e-8)
    np.testing.assert_allclose(left[3:], -off, atol=1e-8)


def test_a_simulated_plan_is_feasible():
    alone = replace(SHORT, estimator=EstimatorParameters(external_time=0.0))  # nothing pulls
    run = simulate(build_closed_loop(alone))
    residual, dropped = feasibility.residuals(run, load_humanoid(run.scenario.robot))
    assert np.abs(residual[50:, :3]).max() < 1e-6
    assert np.median(np.abs(residual[50:, 3:])) < 0.1
    data = saved(
        feasibility.measure(replace(run, mode=np.full(len(run.time), 2.0)), residual, dropped)
    )
    assert data["ticks"] > 0
    (claim,) = feasibility.claims(data)
    assert claim.holds
    check_shown(feasibility, data)


def test_large_residuals_are_counted():
    residual = np.zeros((N, 6))
    residual[:400, 0] = 1e3
    data = saved(feasibility.measure(walk(), residual, np.zeros(N)))
    assert data["large"] == 400
    (claim,) = feasibility.claims(data)
    assert not claim.holds
    assert "400 ticks (20.0 %)" in claim.note
    assert runs.jsonable(data["rows"][0]["max"]) == 1e3
