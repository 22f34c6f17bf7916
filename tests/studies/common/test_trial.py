"""A walk with one command, judged."""

import numpy as np
import pytest

from drake_linefoot.lab.scenario import Segment
from studies.common.trial import judge_walk, lost_walk, often_at_limit
from tests.helpers.recorded_runs import make_run

TIME = np.arange(4001) * 1e-3


def test_torques_at_their_limits_are_named_by_joint():
    limited = np.zeros((1000, 4), dtype=bool)
    limited[:200, 0] = limited[300:600, 1] = limited[:9, 2] = True
    shares = often_at_limit(["hip", "knee", "ankle", "elbow"], limited)
    assert list(shares.items()) == [("knee", 0.3), ("hip", 0.2)]
    assert often_at_limit(["hip"], limited[:0, :1]) == {}


def test_what_a_walk_is_judged_by():
    run = make_run(TIME, segments=[Segment("stand", 2.0), Segment("walk", 2.0, True, [0.0, 0.0])])
    run.command[2000:, 3], run.mode[2000:] = 1.0, 2.0  # it walks in the second half
    run.torque[:2000, 0] = 40.0  # at its limit before it does
    run.torque[2000:2500, 1], run.torque[2250:2750, 2] = -40.0, 39.9
    one, other = run.joint_names[1:3]
    found = judge_walk(run)
    assert found["torque_limited"] == pytest.approx(750 / 2001)
    assert found["at_limit"] == {one: pytest.approx(500 / 2001), other: pytest.approx(500 / 2001)}
    assert (found["roll_rms"], found["pitch_max"], found["fell"]) == (0.0, 0.0, False)
    assert (found["upright"], found["cause"]) == (True, "upright")


def test_a_walk_that_is_lost_has_what_others_have():
    lost = lost_walk("its worker was killed by SIGKILL, 2 times")
    assert set(lost) == set(judge_walk(make_run(TIME, segments=[Segment("stand", 4.0)])))
    assert (lost["upright"], lost["fell"], lost["roll_rms"]) == (False, True, None)
    assert lost["fall_reason"] == "its worker was killed by SIGKILL, 2 times"
