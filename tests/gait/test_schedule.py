"""Knots, contacts and foot motions of schedules that are written down by hand."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_linefoot.gait.schedule import LEFT, RIGHT, Phase, Schedule
from drake_linefoot.gait.state import SIZE
from drake_linefoot.gait.swing import LineMotion, Swing

FEET = np.array([[0.0, 0.1, 0.0, 0.2], [0.1, -0.1, 0.02, -0.1]])


def swing_from(foot, start, end):
    reference = np.zeros((3, SIZE))
    reference[0] = [*foot[:3], 0.0, foot[3]]
    target = np.array([0.4, -0.1, 0.0, 0.0, 0.3])
    return Swing(start, end, start, reference, target, 0.06, 0.03)


def schedule(now=0.5):
    """Both, left (right swings), both, right (no swing given), both for ever."""
    swing = swing_from(FEET[RIGHT], now + 0.03, now + 0.23)
    landed = FEET.copy()
    landed[RIGHT] = [0.4, -0.1, 0.0, 0.3]
    return Schedule(
        (
            Phase(now, now + 0.03, (True, True), FEET),
            Phase(now + 0.03, now + 0.23, (True, False), landed, swing),
            Phase(now + 0.23, now + 0.26, (True, True), landed),
            Phase(now + 0.26, now + 0.46, (False, True), landed),
            Phase(now + 0.46, np.inf, (True, True), landed),
        )
    )


def chain(lengths):
    """Consecutive phases of the given lengths from 0, the last for ever."""
    ends = np.cumsum(lengths)
    starts = [0.0, *ends]
    both = (True, True)
    return Schedule(
        tuple(Phase(a, b, both, FEET) for a, b in zip(starts, [*ends, np.inf], strict=True))
    )


@given(
    st.lists(st.floats(0.001, 0.5), min_size=1, max_size=8),
    st.floats(0.0, 1.0),
    st.integers(1, 40),
    st.floats(0.005, 0.1),
)
def test_no_phase_ends_between_two_knots(lengths, at, count, step):
    plan = chain(lengths)
    knots = plan.knots(at, count, step)
    assert knots.shape == (count + 1,)
    assert knots[0] == at
    dt = np.diff(knots)
    assert np.all(dt > 0.0)
    assert dt.max() <= step * (1 + 1e-5)
    for boundary in np.cumsum(lengths):
        inside = (knots[:-1] < boundary - 1e-8) & (boundary + 1e-8 < knots[1:])
        assert not inside.any()


@pytest.mark.parametrize("left", [2e-9, 1e-8, 5e-8, 1e-6])
def test_a_phase_that_is_all_but_over_does_no_harm(left):
    knots = chain([0.2, 0.3]).knots(0.2 - left, 5, 0.04)
    assert np.all(np.diff(knots) > 0.0)
    assert knots[-1] > 0.2


def test_knots_are_even_within_a_phase_and_steps_as_long_as_may_be():
    knots = chain([0.1, 0.09]).knots(0.0, 7, 0.04)
    np.testing.assert_allclose(np.diff(knots), [0.1 / 3] * 3 + [0.03] * 3 + [0.04], rtol=1e-12)


@pytest.mark.parametrize(
    ("count", "step"), [(0, 0.04), (-1, 0.04), (5, 0.0), (5, -0.1), (5, np.nan)]
)
def test_an_impossible_horizon_is_refused(count, step):
    with pytest.raises(ValueError, match="must be positive"):
        chain([0.1]).knots(0.0, count, step)


def test_contacts_are_those_of_the_phase_and_a_boundary_belongs_to_the_later_one():
    times = 0.5 + np.array([0.0, 0.02, 0.03, 0.1, 0.23, 0.25, 0.26, 0.4, 0.46, 9.0])
    both, left, right = [True, True], [True, False], [False, True]
    expected = [both, both, left, left, both, both, right, right, both, both]
    np.testing.assert_array_equal(schedule().contacts(times), expected)


def test_each_interval_between_knots_has_one_contact_state():
    plan = schedule()
    knots = plan.knots(0.5, 14, 0.04)
    for a, b in pairwise(knots):
        inside = plan.contacts(np.linspace(a + 1e-6, b - 1e-6, 7))
        assert (inside == inside[0]).all()


def test_the_swing_side_is_the_foot_in_the_air():
    sides = [phase.swing_side for phase in schedule().phases]
    assert sides == [None, RIGHT, None, LEFT, None]


def foot_motion(plan, side, times):
    both = plan.feet_motion(times)
    return LineMotion(both.position[side], both.velocity[side], both.acceleration[side])


def test_a_standing_foot_rests_and_a_swinging_one_moves_from_place_to_place():
    plan = schedule()
    times = 0.5 + np.linspace(0.0, 0.5, 101)
    left, right = foot_motion(plan, LEFT, times), foot_motion(plan, RIGHT, times)
    np.testing.assert_array_equal(left.position, np.tile([0.0, 0.1, 0.0, 0.0, 0.2], (101, 1)))
    np.testing.assert_array_equal(left.velocity, 0.0)
    np.testing.assert_allclose(right.position[0], [0.1, -0.1, 0.02, 0.0, -0.1], atol=1e-15)
    np.testing.assert_allclose(right.position[-1], [0.4, -0.1, 0.0, 0.0, 0.3], atol=1e-15)
    assert np.abs(np.diff(right.position, axis=0)).max() < 0.03  # goes from one to the other
    h = 1e-6
    for t in (0.57, 0.61, 0.68):
        p = foot_motion(plan, RIGHT, np.array([t - h, t, t + h]))
        np.testing.assert_allclose(
            (p.position[2] - p.position[0]) / (2 * h), p.velocity[1], atol=1e-6
        )
        numeric = (p.velocity[2] - p.velocity[0]) / (2 * h)
        np.testing.assert_allclose(numeric, p.acceleration[1], atol=1e-5)


def test_foot_motion_does_not_depend_on_which_times_are_asked_together():
    plan, times = schedule(), 0.5 + np.array([0.0, 0.05, 0.12, 0.22, 0.26, 0.4])
    together = foot_motion(plan, RIGHT, times).position
    alone = [foot_motion(plan, RIGHT, times[i : i + 1]).position[0] for i in range(len(times))]
    np.testing.assert_allclose(together, alone, rtol=0, atol=1e-15)
