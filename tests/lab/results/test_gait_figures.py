"""Figures of the gait, of logs made by hand whose answers are known."""

import numpy as np
import pytest

from drake_linefoot.lab.results.gait_figures import flights, standing_feet
from drake_linefoot.lab.results.metrics import compute_metrics
from drake_linefoot.lab.results.tables import gait_rows, summary_rows
from drake_linefoot.lab.results.thresholds import thresholds_of
from drake_linefoot.lab.scenario import Segment
from drake_linefoot.lab.simulation.run_view import humanoid_named
from tests.helpers.recorded_runs import make_run
from tests.helpers.similar import similar_robot, similar_run

TIME = np.arange(6001) * 1e-3
SPEED, STANCE, FLIGHT = 2.0, 110, 60  # [m/s], [ms], [ms]
TORQUE, FAST, SLOW = 10.0, 2.0, -1.0  # [N m] at a joint that turns one way and back [rad/s]


def loads(stance, step):
    """Normal forces of feet that stand in turn, both times in samples, shape (n, 2, 2)."""
    at = np.arange(len(TIME)) % (2 * step)
    stands = np.stack([at < stance, (at - step) % (2 * step) < stance], axis=1)
    return np.where(stands[:, :, None], 150.0, 0.0) * np.ones(2)


def moving(stance=STANCE, step=STANCE + FLIGHT, speed=SPEED, **channels):
    """A robot that goes forward at a speed and works at one joint."""
    n, q = len(TIME), np.zeros((len(TIME), 25))
    q[:, 0], q[:, 4], q[:, 6] = 1.0, speed * TIME, 0.65
    v, torque = np.zeros((n, 24)), np.zeros((n, 18))
    knee = humanoid_named("mit_humanoid").actuated_v[3]
    v[:, knee] = np.where(np.arange(n) % 2, FAST, SLOW)
    torque[:, 3] = TORQUE
    given = {"q": q, "v": v, "applied_torque": torque, "true_normal": loads(stance, step)}
    segments = [Segment("go", 6.0, True, [speed, 0.0])]
    return make_run(TIME, segments=segments, **{**given, **channels})


def gait_of(run):
    return compute_metrics(run)["segments"][-1]["gait"]


def test_a_run_with_flights():
    gait, h = gait_of(moving()), humanoid_named("mit_humanoid")
    assert gait["flight_s"] == pytest.approx(1e-3 * FLIGHT)
    assert gait["flights"] == pytest.approx(3.0 / 0.17, abs=2.0)
    assert gait["duty_factor"] == pytest.approx(STANCE / (2.0 * (STANCE + FLIGHT)))
    assert gait["froude_number"] == pytest.approx(SPEED**2 / (9.81 * h.com_height))
    weight = 9.81 * h.mass  # positive power 10 N m x 2 rad/s in half the ticks
    assert gait["cost_of_transport"] == pytest.approx(10.0 / (weight * SPEED), rel=1e-3)
    assert gait["cost_of_transport_absolute"] == pytest.approx(15.0 / (weight * SPEED), rel=1e-3)


def test_a_walk_has_no_flight_and_a_larger_duty_factor():
    gait = gait_of(moving(stance=230, step=200))
    assert gait["flights"] == 0
    assert gait["flight_s"] is None
    assert gait["duty_factor"] == pytest.approx(230 / 400)


def test_a_change_of_feet_is_no_flight_and_a_bounce_no_second_one():
    run = moving(stance=195, step=200)  # 5 ms without a foot
    assert len(flights(run.time, standing_feet(run), thresholds_of(run))) == 0
    load = loads(STANCE, STANCE + FLIGHT)
    load[STANCE + FLIGHT + 3, 1] = 0.0  # the first touchdown bounces
    found = flights(TIME, standing_feet(moving(true_normal=load)), thresholds_of(run))
    np.testing.assert_array_equal(found[0], [STANCE, STANCE + FLIGHT])
    assert found[1][0] == 2 * STANCE + FLIGHT


def test_flights_that_begin_or_end_a_record_do_not_count():
    load = np.zeros((len(TIME), 2, 2))
    load[100:200, 0] = load[300:400, 1] = 150.0
    found = flights(TIME, standing_feet(moving(true_normal=load)), thresholds_of(moving()))
    np.testing.assert_array_equal(found, [[200, 300]])


def test_a_robot_that_stands_or_steps_in_place_has_no_transport():
    assert gait_of(moving(true_normal=np.full((len(TIME), 2, 2), 60.0))) is None
    gait = gait_of(moving(stance=230, step=200, speed=0.0))
    assert gait["froude_number"] == 0.0
    assert gait["cost_of_transport"] is None


def test_the_share_of_ticks_with_any_torque_at_its_limit():
    torque = np.zeros((len(TIME), 18))
    torque[::10, 3], torque[::10, 4] = 40.0, -40.0  # in the same ticks
    torque[5::10, 7] = -39.9
    torque[2::10, 0] = 39.0  # near it
    run = moving(torque=torque)
    assert compute_metrics(run)["torque_at_limit"] == pytest.approx(0.2, abs=1e-3)
    assert gait_of(run)["torque_at_limit"] == pytest.approx(0.2, abs=1e-3)


def test_a_plant_that_reports_no_torque_has_no_cost():
    gait = gait_of(moving(applied_torque=np.full((len(TIME), 18), np.nan)))
    assert gait["cost_of_transport"] is None
    assert gait["flight_s"] == pytest.approx(1e-3 * FLIGHT)


def test_figures_without_a_unit_are_those_of_a_similar_robot(tmp_path):
    run = moving()
    mit, small = gait_of(run), gait_of(similar_run(run, similar_robot(tmp_path)))
    assert small.pop("flight_s") == pytest.approx(0.5 * mit.pop("flight_s"))
    assert small == pytest.approx(mit, rel=1e-6)


def test_the_table_says_them():
    metrics = compute_metrics(moving())
    ((name, flight, duty, froude, *cost, limit),) = gait_rows(metrics)
    assert (name, flight, duty, limit) == ("go", "60", "0.32", "0%")
    assert froude == f"{4.0 / (9.81 * humanoid_named('mit_humanoid').com_height):.2f}"
    assert cost == ["0.02", "0.03"]
    assert gait_rows(compute_metrics(make_run(TIME))) == []
    assert summary_rows(metrics)["a torque at its limit"] == ("0.0 % of the time",)
