"""Quintics and bumps: end conditions, derivatives, continuity."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.polynomial import Polynomial

from drake_linefoot.math.splines import bump, landing_bump, quintic

ENDS = arrays(float, (3, 2), elements=st.floats(-3.0, 3.0))
DURATIONS = st.floats(0.1, 2.0)


def scale_of(start, end, T):
    """A size to measure rounding by: the largest acceleration that can occur, about."""
    return 200.0 * (1.0 + np.abs(start).max() + np.abs(end).max()) * (1.0 + 1.0 / T**2)


@given(ENDS, ENDS, DURATIONS)
def test_quintic_meets_its_ends(start, end, T):
    for motion, state in zip(
        quintic(start, end, T, np.array([0.0, T])).swapaxes(0, 1), (start, end), strict=True
    ):
        np.testing.assert_allclose(motion, state, atol=1e-14 * scale_of(start, end, T))


@given(ENDS, ENDS, DURATIONS)
def test_quintic_is_the_polynomial_of_degree_five_that_meets_the_ends(start, end, T):
    """The six conditions, written down and solved, have one solution."""
    rows = []
    for t in (0.0, 1.0):
        for order in range(3):
            unit = [Polynomial.basis(j).deriv(order)(t) if order else t**j for j in range(6)]
            rows.append(unit)
    units = np.array([[1.0], [T], [T**2]])
    c = np.linalg.solve(np.array(rows, dtype=float), np.vstack([start * units, end * units]))
    s = np.linspace(0.0, 1.0, 9)
    for i in range(2):
        polynomial = Polynomial(c[:, i])
        for order, found in enumerate(quintic(start, end, T, T * s)):
            p = polynomial.deriv(order) if order else polynomial
            np.testing.assert_allclose(
                found[:, i], p(s) / T**order, rtol=0, atol=1e-13 * scale_of(start, end, T)
            )


@given(ENDS, ENDS, DURATIONS, st.floats(0.02, 0.98))
def test_derivatives_of_the_quintic(start, end, T, s):
    h, t = 1e-5 * T, s * T
    before, now, after = quintic(start, end, T, np.array([t - h, t, t + h])).swapaxes(0, 1)
    tolerance = 1e-7 * scale_of(start, end, T) * max(T, 1 / T)
    for order in (0, 1):
        rate = (after[order] - before[order]) / (2 * h)
        np.testing.assert_allclose(now[order + 1], rate, rtol=0, atol=tolerance)


def test_quintic_shapes_and_clamping():
    start, end = np.zeros((3, 4)), np.eye(3, 4)
    p, v, a = quintic(start, end, 0.5, np.array([-1.0, 0.2, 3.0]))
    assert p.shape == v.shape == a.shape == (3, 4)
    np.testing.assert_array_equal([p[0], v[0], a[0]], start)
    np.testing.assert_allclose([p[2], v[2], a[2]], end, rtol=0, atol=1e-13)
    alone = quintic(start, end, 0.5, np.array([0.2]))[:, 0]
    np.testing.assert_array_equal([p[1], v[1], a[1]], alone)


def test_quintic_between_equal_points_stays():
    rest = np.array([[1.0, -2.0], [0.0, 0.0], [0.0, 0.0]])
    p, v, a = quintic(rest, rest, 0.3, np.linspace(0, 0.3, 20))
    np.testing.assert_array_equal(p, np.tile(rest[0], (20, 1)))
    np.testing.assert_array_equal(v, 0.0)
    np.testing.assert_array_equal(a, 0.0)


@pytest.mark.parametrize("duration", [1e-3, 0.2])
def test_a_quintic_is_exact_to_rounding_however_short(duration):
    """Against fractions: way is lost in a difference of near numbers only once."""
    start = np.array([[0.7 + 1e-7], [1e-4], [0.3]])
    end = np.array([[0.7], [0.0], [0.0]])
    found = quintic(start, end, duration, np.array([0.4 * duration]))[2, 0, 0]
    T, (p0, v0, a0) = Fraction(duration), [Fraction(x) for x in start[:, 0].tolist()]
    way, s = Fraction(end[0, 0]) - p0, Fraction(0.4 * duration) / T
    v, a = v0 * T, a0 * T * T
    c = [10 * way - 6 * v - 3 * a / 2, -15 * way + 8 * v + 3 * a / 2, 6 * way - 3 * v - a / 2]
    exact = (a + 6 * c[0] * s + 12 * c[1] * s**2 + 20 * c[2] * s**3) / (T * T)
    assert found == pytest.approx(float(exact), rel=1e-12, abs=1e-15)


def test_replanning_in_the_middle_changes_nothing():
    """The rest of a quintic is the quintic from its present state to the same end."""
    rng = np.random.default_rng(1)
    start, end, T, t = rng.normal(size=(3, 3)), rng.normal(size=(3, 3)), 0.4, 0.15
    middle = quintic(start, end, T, np.array([t])).reshape(3, 3)
    later = np.linspace(t, T, 11)
    for whole, rest in zip(
        quintic(start, end, T, later), quintic(middle, end, T - t, later - t), strict=True
    ):
        np.testing.assert_allclose(rest, whole, rtol=0, atol=1e-9)


@given(st.floats(-0.3, 0.3), DURATIONS)
def test_bump_is_at_rest_at_both_ends_and_highest_in_the_middle(height, T):
    value, rate, curvature = bump(height, T, np.array([-1.0, 0.0, 0.5 * T, T, T + 1.0]))
    ends = [0, 1, 3, 4]
    for signal in (value, rate, curvature):
        np.testing.assert_allclose(signal[ends], 0.0, rtol=0, atol=1e-15)
    assert value[2] == pytest.approx(height, abs=1e-15)
    assert rate[2] == pytest.approx(0.0, abs=1e-15)
    assert np.abs(bump(height, T, np.linspace(0, T, 101))[0]).max() <= abs(height) * (1 + 1e-12)


@given(st.floats(-0.3, 0.3), DURATIONS, st.floats(0.01, 0.99))
def test_derivatives_of_the_bump(height, T, s):
    h, t = 1e-5 * T, s * T
    value, rate, curvature = bump(height, T, np.array([t - h, t, t + h]))
    assert rate[1] == pytest.approx((value[2] - value[0]) / (2 * h), abs=1e-8 / T)
    assert curvature[1] == pytest.approx((rate[2] - rate[0]) / (2 * h), abs=1e-7 / T**2)


@given(st.floats(0.01, 0.3), DURATIONS, st.floats(0.0, 1.0))
def test_bump_is_symmetric_in_time(height, T, s):
    value, rate, curvature = bump(height, T, np.array([s * T, (1.0 - s) * T]))
    assert value[0] == pytest.approx(value[1], abs=1e-14)
    assert rate[0] == pytest.approx(-rate[1], abs=1e-12)
    assert curvature[0] == pytest.approx(curvature[1], abs=1e-10)


def test_motions_are_continuous_through_their_ends():
    """Value, rate and curvature meet what comes before and after: a resting foot."""
    t = np.array([-1e-9, 1e-9, 0.3 - 1e-9, 0.3 + 1e-9])
    rest = np.zeros((3, 1))
    end = np.array([[1.0], [0.0], [0.0]])
    for signal in (*quintic(rest, end, 0.3, t), *bump(0.1, 0.3, t)):
        jumps = np.abs(np.diff(signal.reshape(4)))[[0, 2]]
        assert jumps.max() < 1e-5


@pytest.mark.parametrize("duration", [0.0, -0.1, np.nan])
def test_durations_that_are_none_are_refused(duration):
    ends = np.zeros((3, 1))
    with pytest.raises(ValueError, match="duration"):
        quintic(ends, ends, duration, np.zeros(1))
    with pytest.raises(ValueError, match="duration"):
        bump(0.1, duration, np.zeros(1))


@given(st.floats(0.01, 0.3), st.floats(0.05, 0.5), st.floats(0.0, 1.0))
def test_a_landing_bump_is_a_polynomial_that_begins_and_ends_at_rest(height, T, s):
    """It is the one of fifth degree with a triple zero at the start and a double one at the end."""
    p = np.poly1d([0.0, 0.0, 0.0, 1.0, 1.0], r=True)
    top = np.linspace(0.0, 1.0, 100001)
    share = height / p(top).max()
    t = np.array([s * T])
    expected = [share * p(s), share * p.deriv()(s) / T, share * p.deriv(2)(s) / T**2]
    np.testing.assert_allclose(
        landing_bump(height, T, t)[:, 0], expected, atol=1e-8 * height / T**2
    )
    assert landing_bump(height, T, T * top[::100])[0].max() == pytest.approx(height, rel=1e-4)
