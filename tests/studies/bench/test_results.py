"""`bench.json` has every key; what was not measured is null and says why."""

import json

import pytest

from studies.bench.measures import THRESHOLDS, Results, Summary

NAMES = {
    "wbc_tick_over_placo",
    "estimator_over_plant_step",
    "mpc_update_over_daqp",
    "mpc_active_set_over_daqp",
    "closed_loop_over_plant_step",
    "map_over_none",
    "realtime_rate_1khz",
    "realtime_rate_500hz",
    "memory_growth_mb",
    "import_over_pydrake",
    "help_over_pydrake",
    "first_walk_cpu_s",
    "first_walk_wall_s",
    "mpc_40_over_10_knots",
    "closed_loop_over_plant_step_busy",
    "closed_loop_over_other",
    "plant_step_over_other",
    "sweep_runs_per_core_minute",
}


def test_keys_are_those_that_are_promised():
    assert set(THRESHOLDS) == NAMES


def test_nothing_measured_is_null_with_a_note_each():
    data = Results().as_dict()
    assert {name: data[name] for name in NAMES} == dict.fromkeys(NAMES)
    assert set(data["notes"]) == NAMES


@pytest.mark.parametrize("value", [None, float("nan"), float("inf")])
def test_what_is_no_number_is_null_and_keeps_its_reason(value):
    results = Results(values={"wbc_tick_over_placo": value})
    results.notes["wbc_tick_over_placo"] = "no PlaCo"
    data = json.loads(json.dumps(results.as_dict(), allow_nan=False))
    assert data["wbc_tick_over_placo"] is None
    assert data["notes"]["wbc_tick_over_placo"] == "no PlaCo"
    bar = data["bars"]["wbc_tick_over_placo"]
    assert (bar["value"], bar["bar"], bar["most"], bar["met"]) == (None, 1.2, True, None)


def test_bars_hold_up_to_their_value():
    measured = {
        "estimator_over_plant_step": 0.2,
        "help_over_pydrake": 2.1,
        "realtime_rate_1khz": 2.0,
    }
    found = {key: bar["met"] for key, bar in Results(values=measured).as_dict()["bars"].items()}
    known = {key: met for key, met in found.items() if met is not None}
    assert known == {"estimator_over_plant_step": True, "help_over_pydrake": False}
    assert set(found) == NAMES  # of a rate that nothing is asked of, too


def test_times_are_told_in_milliseconds():
    results = Results(times={"wbc_tick": Summary(2e-4, 3e-4, 7), "placo_tick": None})
    times = results.as_dict()["times"]
    assert times["wbc_tick"]["median_ms"] == pytest.approx(0.2)
    assert times["placo_tick"] is None
