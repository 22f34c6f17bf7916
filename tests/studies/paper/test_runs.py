import numpy as np
import pytest

from drake_linefoot.lab.scenario.load import load_scenario
from studies.common import runs
from tests.helpers.made_up import PERIOD, circle, walk
from tests.helpers.recorded_runs import short_run


def test_scenario_is_the_shipped_one_but_for_what_is_asked():
    assert runs.paper_scenario(False) == load_scenario("paper")
    quick = runs.paper_scenario(True, "srbm", 3)
    assert quick.duration < runs.paper_scenario(False).duration
    assert (quick.mpc.model, quick.seed) == ("srbm", 3)
    assert quick.mpc.weights == load_scenario("paper").mpc.weights


def test_gains_are_zero_and_the_robot_walks_and_turns():
    scenario = load_scenario("paper")
    w = scenario.wbc
    assert (w.com_position_gain, w.com_velocity_gain, w.angular_momentum_gain) == (0.0, 0.0, 0.0)
    last = scenario.segments[-1]
    assert last.walk
    assert last.velocity[0] > 0.0
    assert last.turn_rate > 0.0


def test_a_scenario_is_simulated_once(monkeypatch):
    calls = []

    def simulate(loop):
        calls.append(loop)
        return "run"

    monkeypatch.setattr(runs, "simulate", simulate)
    monkeypatch.setattr(runs, "build_closed_loop", lambda scenario: scenario)
    monkeypatch.setattr(runs, "_simulated", {})
    for seed in (7, 7, 8):
        assert runs.simulated(runs.paper_scenario(True, seed=seed)) == "run"
    assert len(calls) == 2


def test_running_mean_takes_out_a_whole_stride_and_keeps_a_line():
    time = np.arange(1001) * 1e-3
    sway = np.sin(2.0 * np.pi * time / 0.2)
    middle = slice(200, -200)
    assert np.abs(runs.stride_mean(time, sway, 0.2)[middle]).max() < 0.01
    line = np.column_stack([time, 2.0 * time])
    np.testing.assert_allclose(runs.stride_mean(time, line, 0.2)[middle], line[middle], atol=1e-9)


def test_heading_frame_of_a_circle():
    time = np.arange(2001) * 1e-3
    _, v, quaternion = circle(time, 0.5, 0.8)
    q = np.zeros((2001, 25))
    q[:, :4] = quaternion
    turned = runs.in_heading(walk(q=q), v)
    np.testing.assert_allclose(turned, np.tile([0.5, 0.0, 0.0], (2001, 1)), atol=1e-9)
    np.testing.assert_allclose(runs.turn_rate(walk(q=q)), 0.8, atol=1e-6)


def test_updates_and_walking():
    run = walk(1.0)
    np.testing.assert_array_equal(runs.updates(run), np.arange(0, 1001, PERIOD))
    mode = np.repeat([0.0, 1.0, 2.0, 3.0, 1.0], [200, 200, 200, 200, 201])
    np.testing.assert_array_equal(runs.walking(walk(1.0, mode=mode)), np.arange(1001) >= 400)


def test_measured_motion_is_that_of_the_recorded_centre_of_mass():
    run = short_run()
    motion = runs.centroidal(run)
    np.testing.assert_allclose(motion["r"], run.com, atol=1e-9)
    np.testing.assert_allclose(
        np.gradient(run.com, 1e-3, axis=0)[5:-5], motion["v"][5:-5], atol=0.05
    )


def test_numbers_as_json_takes_them():
    assert runs.decimated(np.array([1.23456789, np.nan, 3.0]), 1) == [1.23457, None, 3.0]
    assert runs.decimated(np.arange(12.0).reshape(6, 2), 5) == [[0.0, 1.0], [10.0, 11.0]]
    assert runs.rms(np.array([3.0, np.nan, -3.0])) == 3.0
    assert np.isnan(runs.rms(np.array([])))
    assert runs.jsonable(np.nan) is None
    assert runs.percentile(np.arange(101.0), 95) == pytest.approx(95.0)
