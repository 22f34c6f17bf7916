"""The pendulum's closed forms against numerical integration of its differential equations."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from drake_linefoot.gait.pendulum import (
    AMPLITUDE,
    BEGIN,
    CENTRE,
    END,
    RATE,
    balancing_cop,
    dcm_offset,
    follow_dcm,
    natural_frequency,
    propagate_dcm,
    switch_time,
)
from drake_linefoot.layout import parts_of
from drake_linefoot.parts import FOREVER
from drake_linefoot.signals import GaitHorizon
from tests.helpers.horizons import Piece, rows_of
from tests.helpers.pendulum_robot import dcm_on

OMEGA = 3.9
TIGHT = {"rtol": 1e-11, "atol": 1e-13, "method": "DOP853"}
lengths = st.floats(-2.0, 2.0)
points = st.tuples(lengths, lengths).map(np.array)


def integrate(rate, start, duration):
    """The state after `duration`, from `rate(t, state)`."""
    return solve_ivp(rate, (0.0, duration), start, **TIGHT).y[:, -1]


def test_natural_frequency_is_that_of_a_falling_mass():
    """c'' = w^2 c: the vertical force m g acts on the lever c, at the height h."""
    h, m, c = 0.65, 24.0, 0.1
    moment = m * 9.81 * c
    assert m * natural_frequency(h) ** 2 * c * h == pytest.approx(moment, rel=1e-14)


@pytest.mark.parametrize("height", [0.0, -0.6, np.nan])
def test_a_height_that_is_not_positive_is_refused(height):
    with pytest.raises(ValueError, match="must be positive"):
        natural_frequency(height)


@given(points, points, st.floats(2.0, 6.0), st.floats(0.0, 1.0))
def test_propagate_dcm_integrates_its_equation(xi, cop, omega, duration):
    end = integrate(lambda t, y: omega * (y - cop), xi, max(duration, 1e-9))
    np.testing.assert_allclose(propagate_dcm(xi, cop, omega, duration), end, rtol=1e-8, atol=1e-8)


def test_the_dcm_is_the_capture_point():
    """A pendulum with its CoP at the DCM comes to rest above it."""
    c, v = np.array([0.1, -0.2]), np.array([0.4, 0.3])
    xi = c + v / OMEGA
    np.testing.assert_allclose(propagate_dcm(xi, xi, OMEGA, 3.0), xi, rtol=1e-15)
    rest = integrate(lambda t, y: [*y[2:], *OMEGA**2 * (y[:2] - xi)], [*c, *v], 2.5)
    np.testing.assert_allclose(rest[:2], xi, atol=1e-4)  # exp(-2.5 w) = 6e-5


@pytest.mark.parametrize("double_support", [1e-6, 0.03, 0.1, 0.4])
def test_switch_time_ends_like_a_cop_that_moves_evenly(double_support):
    xi, old, new = np.array([0.05, 0.02]), np.array([0.0, 0.1]), np.array([0.25, -0.1])
    T = double_support
    even = integrate(lambda t, y: OMEGA * (y - old - (new - old) * t / T), xi, T)
    s = switch_time(T, OMEGA)
    jump = propagate_dcm(propagate_dcm(xi, old, OMEGA, s), new, OMEGA, T - s)
    np.testing.assert_allclose(jump, even, atol=1e-11)
    assert 0.4 * T < s <= 0.5 * T  # the earlier CoP counts more


def test_switch_time_without_a_double_support_is_at_once():
    assert switch_time(0.0, OMEGA) == 0.0


@given(points, points, st.floats(0.05, 0.8))
def test_balancing_cop_hits_its_goal(xi, goal, duration):
    cop = balancing_cop(xi, goal, OMEGA, duration)
    end = integrate(lambda t, y: OMEGA * (y - cop), xi, duration)
    np.testing.assert_allclose(end, goal, atol=1e-8)


# --- dcm_offset -------------------------------------------------------------------------


def alternating_walk(count):
    """Strides of a diagonal walk with wide steps: the lateral part has both signs."""
    return np.array([[0.18, 0.03 + 0.16 * (-1) ** k] for k in range(count)])


def walk_open_loop(offset_error=0.0, steps=14):
    """xi - p at each switch of a walk whose strides are fixed, integrated numerically."""
    T, strides = 0.23, alternating_walk(60)
    p = np.zeros(2)
    xi = p + dcm_offset(strides, OMEGA, T) + offset_error
    offsets = [xi - p]
    for k in range(steps):
        xi = integrate(lambda t, y, p=p: OMEGA * (y - p), xi, T)
        p = p + strides[k]
        offsets.append(xi - p)
    return np.array(offsets)


def test_the_offset_keeps_a_periodic_walk_bounded_and_periodic():
    offsets = walk_open_loop()
    # Rounding grows by exp(w T) = 2.45 a step: 1e-12 becomes 3e-7 in 14 steps.
    np.testing.assert_allclose(offsets[2:], offsets[:-2], atol=1e-6)
    assert offsets[0, 1] * offsets[1, 1] < 0.0  # the CoM sways between the feet
    assert np.abs(offsets).max() < 0.3


def test_no_other_offset_keeps_it_bounded():
    """A micrometre too much has become most of a foot's length 14 steps later."""
    assert np.abs(walk_open_loop(1e-6) - walk_open_loop())[-1].min() > 0.1


# --- follow_dcm -------------------------------------------------------------------------


def test_the_columns_of_a_piece_are_those_that_the_signal_names():
    names = parts_of(GaitHorizon)["dcm"].axes[-1]
    assert (names[BEGIN], names[END], names[RATE]) == ("begin", "end", "rate")
    assert names[7] == "omega"
    assert names[CENTRE : CENTRE + 2] == ("centre_x", "centre_y")
    assert names[AMPLITUDE : AMPLITUDE + 2] == ("amplitude_x", "amplitude_y")
    assert len(names) == len(rows_of(pieces_with_jumps())[0]) == 8


def pieces_with_jumps(start=0.3, capture=-3.0):
    """A DCM around three resting CoPs, then captured for ever; continuous."""
    xi = np.array([0.02, 0.01])
    pieces = []
    for cop, length in (([0.0, 0.08], 0.21), ([0.15, -0.08], 0.04), ([0.2, 0.09], 0.17)):
        piece = Piece(start, start + length, np.array(cop), xi - cop, OMEGA, OMEGA)
        pieces.append(piece)
        start, xi = piece.end, dcm_on(piece, piece.end)
    middle = np.array([0.2, 0.0])
    return [*pieces, Piece(start, FOREVER, middle, xi - middle, capture, OMEGA)]


def integrated_com(pieces, com, times):
    """The CoM at `times` from ``c' = w (xi - c)``, one piece after the other."""
    out, c = [], np.array(com)
    now = times[0]
    for piece in pieces:
        inside = times[(times >= piece.start) & (times < piece.end)]
        end = min(piece.end, times[-1] + 1e-6)

        def rate(t, y, piece=piece):
            return OMEGA * (dcm_on(piece, t) - y)

        solution = solve_ivp(rate, (now, end), c, t_eval=[*inside, end], **TIGHT)
        out.append(solution.y[:, :-1].T)
        now, c = end, solution.y[:, -1]
    return np.vstack(out)


@pytest.mark.parametrize("capture", [-3.0, -OMEGA * (1 + 1e-9), -OMEGA, -9.0])
def test_follow_dcm_integrates_over_jumps_of_the_cop(capture):
    """Also when the DCM is captured exactly as fast as the CoM follows it."""
    pieces, com = pieces_with_jumps(capture=capture), np.array([0.01, 0.03])
    times = np.concatenate([np.linspace(0.3, 1.2, 60), [1.5, 2.0]])
    position, velocity = follow_dcm(com, rows_of(pieces), times)
    np.testing.assert_allclose(position[0], com, atol=1e-15)
    expected = integrated_com(pieces, com, times)
    np.testing.assert_allclose(position, expected, atol=1e-10)
    xi = np.array([dcm_on(next(p for p in pieces if t < p.end), t) for t in times])
    np.testing.assert_allclose(velocity, OMEGA * (xi - expected), atol=1e-9)


def test_follow_dcm_velocity_is_the_derivative_of_position_across_a_jump():
    pieces, com, h = pieces_with_jumps(), np.zeros(2), 1e-6
    for at in (pieces[0].end, pieces[1].end, pieces[2].end, 0.45):
        times = np.array([at - h, at, at + h])
        position, velocity = follow_dcm(com, rows_of(pieces), times)
        numeric = (position[2] - position[0]) / (2 * h)
        np.testing.assert_allclose(velocity[1], numeric, atol=1e-5)  # c'' jumps: O(h c'')


@given(st.floats(0.31, 1.5))
def test_follow_dcm_does_not_depend_on_how_a_piece_is_cut(cut):
    pieces = pieces_with_jumps()
    k = next(i for i, p in enumerate(pieces) if cut < p.end)
    whole = pieces[k]
    first = whole._replace(end=cut)
    second = whole._replace(start=cut, amplitude=dcm_on(whole, cut) - whole.centre)
    times = np.linspace(0.3, 1.8, 40)
    one = follow_dcm(np.ones(2), rows_of(pieces), times)
    cut_pieces = rows_of([*pieces[:k], first, second, *pieces[k + 1 :]])
    two = follow_dcm(np.ones(2), cut_pieces, times)
    np.testing.assert_allclose(two, one, atol=1e-12)
