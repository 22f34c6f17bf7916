"""Knots, contacts and foot motions of horizons that are written down by hand."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_linefoot.gait.schedule import (
    LEFT,
    RIGHT,
    contacts,
    feet_motion,
    knots,
    phase_ends,
)
from drake_linefoot.gait.state import SIZE
from drake_linefoot.gait.swing import LineMotion, Swing
from drake_linefoot.parts import FOREVER
from tests.helpers.horizons import Phase, horizon_of, swing_of

FEET = np.array([[0.0, 0.1, 0.0, 0.2], [0.1, -0.1, 0.02, -0.1]])
BOTH, ON_LEFT, ON_RIGHT = (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)


def swing_from(foot, place, start, end):
    reference = np.zeros((3, SIZE))
    reference[0] = [*foot[:3], 0.0, foot[3]]
    target = np.array([*place[:3], 0.0, place[3]])
    return Swing(start, end, start, reference, target, 0.06, 0.03)


def walk(now=0.5):
    """Both, left (right swings), both, right (left swings), both for ever."""
    landed = FEET.copy()
    landed[RIGHT] = [0.4, -0.1, 0.0, 0.3]
    then = landed.copy()
    then[LEFT] = [0.6, 0.1, 0.0, 0.4]
    first = swing_from(FEET[RIGHT], landed[RIGHT], now + 0.03, now + 0.23)
    second = swing_from(FEET[LEFT], then[LEFT], now + 0.26, now + 0.46)
    return horizon_of(
        [
            Phase(now, now + 0.03, BOTH, FEET),
            Phase(now + 0.03, now + 0.23, ON_LEFT, landed, (None, first)),
            Phase(now + 0.23, now + 0.26, BOTH, landed),
            Phase(now + 0.26, now + 0.46, ON_RIGHT, then, (second, None)),
            Phase(now + 0.46, FOREVER, BOTH, then),
        ]
    )


def chain(lengths):
    """Consecutive phases of the given lengths from 0, the last for ever."""
    ends = np.cumsum(lengths)
    bounds = zip([0.0, *ends], [*ends, FOREVER], strict=True)
    return horizon_of([Phase(a, b, BOTH, FEET) for a, b in bounds])


@given(
    st.lists(st.floats(0.001, 0.5), min_size=1, max_size=8),
    st.floats(0.0, 1.0),
    st.integers(1, 40),
    st.floats(0.005, 0.1),
)
def test_no_phase_ends_between_two_knots(lengths, at, count, step):
    times = knots(chain(lengths), at, count, step)
    assert times.shape == (count + 1,)
    assert times[0] == at
    dt = np.diff(times)
    assert np.all(dt > 0.0)
    assert dt.max() <= step * (1 + 1e-5)
    for boundary in np.cumsum(lengths):
        inside = (times[:-1] < boundary - 1e-8) & (boundary + 1e-8 < times[1:])
        assert not inside.any()


@pytest.mark.parametrize("left", [2e-9, 1e-8, 5e-8, 1e-6])
def test_a_phase_that_is_all_but_over_does_no_harm(left):
    times = knots(chain([0.2, 0.3]), 0.2 - left, 5, 0.04)
    assert np.all(np.diff(times) > 0.0)
    assert times[-1] > 0.2


def test_knots_are_even_within_a_phase_and_steps_as_long_as_may_be():
    times = knots(chain([0.1, 0.09]), 0.0, 7, 0.04)
    np.testing.assert_allclose(np.diff(times), [0.1 / 3] * 3 + [0.03] * 3 + [0.04], rtol=1e-12)


@pytest.mark.parametrize(
    ("count", "step"), [(0, 0.04), (-1, 0.04), (5, 0.0), (5, -0.1), (5, np.nan)]
)
def test_an_impossible_horizon_is_refused(count, step):
    with pytest.raises(ValueError, match="must be positive"):
        knots(chain([0.1]), 0.0, count, step)


def test_contacts_are_those_of_the_phase_and_a_boundary_belongs_to_the_later_one():
    times = 0.5 + np.array([0.0, 0.02, 0.03, 0.1, 0.23, 0.25, 0.26, 0.4, 0.46, 9.0])
    expected = np.repeat([BOTH, ON_LEFT, BOTH, ON_RIGHT, BOTH], 2, axis=0)
    np.testing.assert_array_equal(contacts(walk(), times), expected)


def test_each_interval_between_knots_has_one_contact_state():
    plan = walk()
    for a, b in pairwise(knots(plan, 0.5, 14, 0.04)):
        inside = contacts(plan, np.linspace(a + 1e-6, b - 1e-6, 7))
        assert (inside == inside[0]).all()


def test_a_phase_has_the_swing_of_the_foot_in_the_air_and_none_where_both_stand():
    plan = walk()
    swings = {(i, side): swing_of(plan, i, side) for i in range(5) for side in (LEFT, RIGHT)}
    known = {at: swing for at, swing in swings.items() if swing is not None}
    assert set(known) == {(1, RIGHT), (3, LEFT)}
    for (at, side), start, end in (((1, RIGHT), 0.53, 0.73), ((3, LEFT), 0.76, 0.96)):
        swing = known[at, side]
        expected = swing_from(FEET[side], plan.feet[-1, side], start, end)
        for value, wanted in zip(swing, expected, strict=True):
            np.testing.assert_allclose(value, wanted, atol=1e-15)


def test_phases_end_where_the_next_begins_and_the_last_has_no_end():
    plan = walk()
    np.testing.assert_allclose(phase_ends(plan), [0.53, 0.73, 0.76, 0.96], atol=2e-9)


def foot_motion(plan, side, times):
    both = feet_motion(plan, times)
    return LineMotion(both.position[side], both.velocity[side], both.acceleration[side])


def test_a_standing_foot_rests_and_a_swinging_one_moves_from_place_to_place():
    plan = walk()
    times = 0.5 + np.linspace(0.0, 0.25, 101)
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
    plan, times = walk(), 0.5 + np.array([0.0, 0.05, 0.12, 0.22, 0.26, 0.4])
    together = foot_motion(plan, RIGHT, times).position
    alone = [foot_motion(plan, RIGHT, times[i : i + 1]).position[0] for i in range(len(times))]
    np.testing.assert_allclose(together, alone, rtol=0, atol=1e-15)
