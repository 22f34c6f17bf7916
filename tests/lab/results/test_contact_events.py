import numpy as np
import pytest

from drake_linefoot.lab.results.contact_events import (
    detection,
    intervals,
    largest_slip,
    standing,
    touchdowns,
)
from drake_linefoot.lab.results.thresholds import Thresholds

LIMITS = Thresholds()
TIME = np.arange(1001) * 1e-3


def during(*ranges):
    """Flags that are true in the given ranges of milliseconds, ends excluded."""
    flags = np.zeros(len(TIME), dtype=bool)
    for begin, end in ranges:
        flags[begin:end] = True
    return flags


def normal(*ranges):
    return 100.0 * during(*ranges)


@pytest.mark.parametrize("ranges", [(), ((0, 1001),), ((0, 5), (7, 8), (1000, 1001))])
def test_intervals_give_back_what_made_the_flags(ranges):
    assert intervals(during(*ranges)).tolist() == [list(r) for r in ranges]


def test_a_bounce_is_no_swing_and_a_swing_is():
    stands = standing(TIME, normal((0, 300), (500, 505), (530, 1001)), LIMITS)
    assert intervals(stands).tolist() == [[0, 300], [500, 1001]]
    assert touchdowns(stands).tolist() == [500]


def test_a_run_that_begins_and_ends_unloaded_for_a_moment_stands_throughout():
    stands = standing(TIME, normal((3, 980)), LIMITS)
    assert stands.all()
    assert len(touchdowns(stands)) == 0


def test_perfect_detection():
    stands = during((0, 300), (500, 1001))
    seen = detection(TIME, stands, stands, LIMITS)
    assert seen.latencies.tolist() == [0.0]
    assert (seen.missed, seen.false_positives) == (0, 0)


def test_latency_is_counted_from_the_true_touchdown():
    stands = during((0, 200), (400, 600), (800, 1001))
    seen = detection(TIME, stands, during((0, 203), (404, 605), (810, 1001)), LIMITS)
    assert seen.latencies == pytest.approx([0.004, 0.010])
    assert (seen.missed, seen.false_positives) == (0, 0)


def test_a_touchdown_without_flag_within_50_ms_is_missed():
    stands = during((0, 200), (400, 600), (980, 1001))
    seen = detection(TIME, stands, during((0, 200), (451, 600)), LIMITS)
    assert len(seen.latencies) == 0
    assert seen.missed == 1  # the last one is too near the end to be judged


@pytest.mark.parametrize(
    ("flag", "expected"),
    [
        (((0, 300), (400, 410), (500, 1001)), 1),  # raised in the air
        (((0, 300), (350, 360), (400, 410), (500, 1001)), 2),
        (((0, 340), (500, 1001)), 0),  # released late, but in time
        (((0, 360), (500, 1001)), 1),  # still on 60 ms after lift-off
        (((0, 300), (499, 1001)), 1),  # 1 ms before touchdown
    ],
)
def test_false_positives_are_counted_as_events(flag, expected):
    stands = during((0, 300), (500, 1001))
    assert detection(TIME, stands, during(*flag), LIMITS).false_positives == expected


def test_a_scuff_is_no_stance_and_its_flag_is_not_false():
    load = normal((0, 300), (400, 402), (500, 1001))
    stands = standing(TIME, load, LIMITS)
    assert intervals(stands).tolist() == [[0, 300], [500, 1001]]
    flag = during((0, 300), (404, 410), (503, 1001))
    seen = detection(TIME, stands, flag, LIMITS, load > 0.0)
    assert seen.latencies == pytest.approx([0.003])
    assert (seen.missed, seen.false_positives) == (0, 0)
    late = detection(TIME, stands, during((0, 300), (420, 430), (503, 1001)), LIMITS, load > 0.0)
    assert late.false_positives == 1  # 18 ms after the scuff there was nothing to feel


def test_a_run_may_end_with_a_touchdown():
    assert touchdowns(standing(TIME, normal((0, 300), (998, 1001)), LIMITS)).tolist() == [998]


def test_a_flag_that_was_up_before_detects_nothing():
    stands = during((0, 300), (500, 1001))
    seen = detection(TIME, stands, during((0, 300), (480, 1001)), LIMITS)
    assert len(seen.latencies) == 0
    assert (seen.missed, seen.false_positives) == (0, 1)


def test_slip_is_the_way_of_a_loaded_point_only():
    points = np.zeros((len(TIME), 2, 2, 3))
    load = np.zeros((len(TIME), 2, 2))
    points[:, 1, 0, 0] = TIME  # the right heel moves all the time ...
    load[100:103, 1, 0] = 50.0  # ... and is loaded for 2 ms of it
    points[200:, 0, 1, 1] = -0.004  # the left toe jumps once while it is loaded
    points[:, 0, 1, 2] = TIME  # up and down is no slip
    load[150:300, 0, 1] = 50.0
    assert largest_slip(points, load, LIMITS) == pytest.approx(0.004)
    load[150:201, 0, 1] = 0.0
    assert largest_slip(points, load, LIMITS) == pytest.approx(0.002)
