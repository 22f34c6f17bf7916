"""Figure 2: times with known answers, and one real state."""

import json
from dataclasses import replace

import numpy as np
import pytest

from studies.common.recorder import record
from studies.paper.clock import RHOS, Clock
from studies.paper.fig2 import STAGES, claims, draw, faster, summary, table
from tests.helpers.walking import SCENARIO, recorded_walk


def made_up(gain, spread=0.02, n=80):
    """Times of which the line takes `gain` percent less."""
    rng = np.random.default_rng(4)
    points = 0.4 * (1.0 + spread * rng.normal(size=(n, len(STAGES) + 1)))
    line = points * (1.0 - gain / 100.0) * (1.0 + spread * rng.normal(size=points.shape))
    return np.stack([line, points], axis=1)


def data_of(single, double):
    return {
        "scenario": "",
        "seeds": [0],
        "fell": False,
        "solver": "osqp",
        "repetitions": 3,
        "tuned": {"line": {"rho": 0.1}, "points": {"rho": 0.02}},
        "supports": {"single": summary(made_up(single)), "double": summary(made_up(double))},
    }


def test_the_gain_is_that_of_the_shorter_time():
    assert faster(np.array([0.7, 0.9]), np.array([1.0, 1.0])) == pytest.approx(20.0)
    assert faster(np.array([1.0]), np.array([0.8])) == pytest.approx(-25.0)


def test_gain_and_interval_of_known_times():
    one = summary(made_up(20.0))["qp"]
    assert one["faster"] == pytest.approx(20.0, abs=1.0)
    assert one["interval"][0] < one["faster"] < one["interval"][1]
    assert one["interval"][1] - one["interval"][0] < 2.0
    assert one["points"] == sorted(one["points"])
    assert one["median_faster"] == pytest.approx(20.0, abs=1.0)
    assert one["line"][1] == pytest.approx(0.32, rel=0.02)


def test_claims_hold_only_when_the_interval_is_above_zero():
    found = claims(data_of(20.0, 0.0))
    assert [claim.holds for claim in found] == [True, True, False, False]
    assert [claim.paper for claim in found] == [
        "20.8 % faster",
        "6.4 % faster",
        "21.2 % faster",
        "13.2 % faster",
    ]


def test_table_picture_and_json():
    data = data_of(20.0, 10.0)
    json.dumps(data, allow_nan=False)
    rows = table(data)
    assert len(rows) == 1 + 2 * len(STAGES)
    assert all(len(row) == len(rows[0]) for row in rows)
    assert len(draw(data).axes) == len(STAGES)


def test_both_controllers_are_timed_on_one_state():
    clock = Clock(SCENARIO)
    walk = recorded_walk()
    states = [(tick.x, tick.targets, tick.plan) for tick in walk.swinging[:2]]
    tuned = clock.tune(states)
    assert [len(one["iterations"]) for one in tuned] == [len(RHOS)] * 2
    taken = np.mean([clock.both(*state, points_first=False)[:, -1] for state in states], axis=0)
    assert taken.tolist() == [min(one["iterations"]) for one in tuned]
    for tick in (walk.wbc[0], walk.swinging[0]):
        times = clock.both(tick.x, tick.targets, tick.plan, points_first=True)
        assert times.shape == (2, len(STAGES) + 1)
        assert (times > 0.0).all()
        assert (times[:, -1] == times[:, -1].round()).all()  # iterations


def test_a_recording_has_every_tick():
    segments = [replace(SCENARIO.segments[0], duration=0.05)]
    walk = record(replace(SCENARIO, segments=segments), every=1)
    assert len(walk.ticks) == 50
    assert walk.fall_reason == ""
