"""The judge of a run: what it says of it, and whether the run was upright."""

import dataclasses

import pytest

from drake_linefoot.lab.results.judge import OUTCOME, judge, upright
from drake_linefoot.lab.simulation.run_view import robot_of
from tests.helpers.recorded_runs import short_run


def test_outcome_has_every_column_and_its_type():
    found = judge(short_run())
    assert list(found) == list(OUTCOME)
    types = {"bool": bool, "double": float, "int64": int, "string": str}
    for name, value in found.items():
        assert value is None or isinstance(value, types[OUTCOME[name].kind]), name


def test_a_run_whose_legs_meet_is_not_upright():
    run = short_run()
    fine, q = judge(run), run.q.copy()
    assert (fine["legs_met"], fine["cause"]) == (None, "upright")
    robot = robot_of(run)
    abad = robot.actuated_q[robot.description.actuated_joints.index("left_hip_abad")]
    q[200:, abad] = -0.8
    met = judge(dataclasses.replace(run, q=q))
    assert met["legs_met"] == pytest.approx(run.time[200])
    assert met["leg_gap"] < 0.0
    assert (met["fell"], met["cause"]) == (False, "self-collision")
    assert [upright(found) for found in (fine, met)] == [True, False]
