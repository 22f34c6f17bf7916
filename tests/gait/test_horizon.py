"""The gait over the horizon: in every mode complete, in order, and what then happens."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.gait.schedule import contacts, feet_motion, knots
from drake_linefoot.gait.swing import swing_motion
from drake_linefoot.layout import Layout
from drake_linefoot.parts import AT_KNOTS, FOREVER, PHASES, PIECES
from drake_linefoot.signals import GaitHorizon
from drake_linefoot.statuses import Mode
from tests.helpers.horizons import horizon_at, phases_of, pieces_of
from tests.helpers.pendulum_robot import DT, STAND_STILL, PendulumRobot, dcm_on
from tests.helpers.phases import (
    contact_of,
    in_final_step,
    mode_of,
    phase_end,
    phase_start,
    swing_of,
)

LENGTH = 0.56
COMMAND = [0.5, 0.05, 0.6, 1.0]


@pytest.fixture(scope="module")
def walk():
    """Every state of a walk from stand to stand that turns, with its robot's gait."""
    robot = PendulumRobot(yaw=2.5)
    ticks = robot.run(STAND_STILL, 0.01) + robot.run(COMMAND, 2.0) + robot.run(STAND_STILL, 2.5)
    return robot.constants, [t.state for t in ticks]


@pytest.fixture(scope="module")
def horizons(walk):
    c, states = walk
    return [(s, horizon_at(s, c, LENGTH)) for s in states[::13]]


def test_every_mode_is_there(horizons):
    assert {mode_of(s) for s, _ in horizons} == set(Mode) - {Mode.FLIGHT}
    assert any(in_final_step(s) for s, _ in horizons)


def test_phases_and_dcm_cover_the_horizon_without_gaps(horizons):
    for state, horizon in horizons:
        for parts in (phases_of(horizon), pieces_of(horizon)):
            assert parts[0].start == state.clock.time
            assert parts[0].end > state.clock.time
            for a, b in pairwise(parts):
                assert a.end == b.start
                assert b.end >= b.start
            assert parts[-1].end >= state.clock.time + LENGTH - 1e-9


def test_the_first_phase_is_the_present_one(horizons):
    for state, horizon in horizons:
        first = phases_of(horizon)[0]
        assert first.contact == contact_of(state)
        assert first.end == min(phase_end(state), FOREVER)
        stands = [side for side in (0, 1) if first.contact[side]]
        np.testing.assert_array_equal(first.feet[stands], state.robot.feet[stands])
        assert horizon.time == state.clock.time


def test_at_least_one_foot_stands_and_supports_alternate(horizons):
    for _, horizon in horizons:
        phases = phases_of(horizon)
        swings = [p.swing_side for p in phases if p.swing_side is not None]
        assert all(any(p.contact) for p in phases)
        assert all(a != b for a, b in pairwise(swings))


def test_footholds_are_where_the_swings_land_in_order(horizons):
    for _, horizon in horizons:
        swings = [p for p in phases_of(horizon) if p.swing is not None]
        assert horizon.coming == len(swings)
        for place, phase in zip(horizon.footholds[: len(swings)], swings, strict=True):
            end = swing_motion(phase.swing, np.array([phase.end]))[0, 0]
            np.testing.assert_allclose(end[[0, 1, 2]], place[:3], atol=1e-12)
            assert np.cos(end[4] - place[3]) == pytest.approx(1.0, abs=1e-12)
            np.testing.assert_array_equal(phase.feet[phase.swing_side], place)


def test_a_foot_moves_only_in_its_swing_and_never_jumps(horizons):
    for state, horizon in horizons[::4]:
        times = state.clock.time + np.arange(0.0, LENGTH, DT)
        contact = contacts(horizon, times) == 1.0
        for side in (0, 1):
            p = feet_motion(horizon, times).position[side]
            step = np.abs(np.diff(p[:, :3], axis=0)).max(axis=1)
            assert step.max() < 0.012
            standing = contact[:-1, side] & contact[1:, side]
            assert step[standing].max(initial=0.0) < 1e-12


def test_the_dcm_is_continuous_and_moves_by_its_law_around_the_standing_feet(horizons):
    for state, horizon in horizons[::3]:
        start = state.robot.com[:2] + state.robot.com_velocity[:2] / horizon.omega
        pieces = pieces_of(horizon)
        np.testing.assert_allclose(dcm_on(pieces[0], state.clock.time), start, atol=1e-12)
        for a, b in pairwise(pieces):
            np.testing.assert_allclose(dcm_on(a, a.end), dcm_on(b, b.start), atol=1e-12)
        for piece in pieces:
            if piece.rate > 0.0:

                def rate(t, xi, omega=horizon.omega, cop=piece.centre):
                    return omega * (xi - cop)

                xi = solve_ivp(
                    rate,
                    (piece.start, piece.end),
                    dcm_on(piece, piece.start),
                    rtol=1e-10,
                    atol=1e-12,
                ).y[:, -1]
                np.testing.assert_allclose(dcm_on(piece, piece.end), xi, atol=1e-9)


def test_the_dcm_stays_near_the_feet(horizons):
    """Plans that diverge would leave the feet by metres."""
    for state, horizon in horizons:
        for t in np.linspace(state.clock.time, state.clock.time + LENGTH, 15):
            piece = next(p for p in pieces_of(horizon) if t <= p.end)
            phase = next(p for p in phases_of(horizon) if t < p.end)
            away = np.linalg.norm(phase.feet[:, :2] - dcm_on(piece, t), axis=1).min()
            assert away < 0.5


def test_the_dcm_of_a_phase_ends_where_the_robot_takes_it(walk):
    """From anywhere in a swing, and over whole double supports, to the end of the phase."""
    c, states = walk
    ends = {
        (phase_start(s), mode_of(s)): k for k, s in enumerate(states)
    }  # last tick of each phase
    checked = set()
    begins = [s for s in states if mode_of(s) == Mode.DOUBLE and s.clock.time == phase_start(s)]
    for state in [*begins, *(s for s in states[::7] if mode_of(s) == Mode.SWING)]:
        last = states[ends[phase_start(state), mode_of(state)] + 1]
        dcm = last.robot.com[:2] + last.robot.com_velocity[:2] / c.omega
        pieces = pieces_of(horizon_at(state, c, LENGTH))
        planned = dcm_on(
            next(p for p in pieces if last.clock.time <= p.end + 1e-9), last.clock.time
        )
        np.testing.assert_allclose(planned, dcm, atol=1e-5)
        checked.add(mode_of(state))
    assert checked == {Mode.SWING, Mode.DOUBLE}


def test_the_plan_is_what_the_gait_then_does():
    """An undisturbed walk at a steady command lands where it was planned two steps before."""
    robot = PendulumRobot()
    ticks = robot.run([0.5, 0.0, 0.4, 1.0], 3.0)
    plan = horizon_at(ticks[-1].state, robot.constants, 0.7)
    ticks = robot.run([0.5, 0.0, 0.4, 1.0], 0.8)
    landed = []
    for a, b in pairwise(t.state for t in ticks):
        if b.clock.steps > a.clock.steps:
            landed.append([*swing_of(a).target[:3], swing_of(a).target[4], b.clock.time])
    ends = [p.end for p in phases_of(plan) if p.swing is not None]
    for place, planned, end in zip(landed, plan.footholds, ends, strict=False):
        np.testing.assert_allclose(place[:3], planned[:3], atol=3e-3)  # learning goes on
        assert np.cos(place[3] - planned[3]) == pytest.approx(1.0, abs=1e-9)
        assert place[4] == pytest.approx(end, abs=1e-6)
    assert min(len(landed), len(ends)) >= 2


def test_heading_and_height_of_the_horizon(horizons):
    for state, horizon in horizons:
        assert (horizon.yaw, horizon.turn_rate) == (state.command.yaw, state.command.turn_rate)
        expected = state.robot.feet[int(state.clock.side), 2] + GaitParameters().com_height
        assert horizon.com_height == pytest.approx(expected)


@pytest.mark.parametrize("length", [0.05, 0.56, 1.5])
@pytest.mark.parametrize("double_support", [0.001, 0.03, 0.1])
def test_horizons_of_any_length_and_double_supports_of_any_length(length, double_support):
    robot = PendulumRobot(GaitParameters(double_support=double_support))
    for tick in robot.run(COMMAND, 1.3)[::37]:
        horizon = horizon_at(tick.state, robot.constants, length)
        assert phases_of(horizon)[-1].end >= tick.state.clock.time + length - 1e-9
        assert pieces_of(horizon)[-1].end >= tick.state.clock.time + length - 1e-9
        count = int(length / 0.04)
        times = knots(horizon, tick.state.clock.time, max(count, 1), 0.04)
        assert np.all(np.diff(times) > 0.0)


@pytest.mark.parametrize("count", [1, 5, 40])
def test_a_horizon_has_the_rows_of_its_knots_and_zeros_behind_those_that_count(walk, count):
    c, states = walk
    layout = Layout(GaitHorizon, {"knots": count})
    for state in states[::101]:
        horizon = horizon_at(state, c, LENGTH, count)
        counts = {PHASES: horizon.phases, PIECES: horizon.pieces, AT_KNOTS: horizon.coming}
        for name, part in layout.parts.items():
            assert np.shape(getattr(horizon, name)) == part.shape({"knots": count}), name
            if part.axes and part.axes[0] in counts:
                assert not getattr(horizon, name)[int(counts[part.axes[0]]) :].any(), name


@pytest.mark.parametrize("lead", [0.0, 0.02])
@pytest.mark.parametrize("count", [1, 3, 8])
def test_what_is_left_out_is_beyond_the_knots(walk, count, lead):
    """No more phases than knots are reached from the first one, also of a plan that is late."""
    c, states = walk
    for state in states[::101]:
        long, short = (horizon_at(state, c, 5.0, n) for n in (60, count))
        assert short.phases == min(long.phases, count + 12)
        assert short.pieces <= min(long.pieces, count + 14)
        assert short.coming == min(long.coming, count + 1)
        begin = state.clock.time + lead
        times = knots(long, begin, count, 0.1)
        np.testing.assert_array_equal(knots(short, begin, count, 0.1), times)
        middle = 0.5 * (times[1:] + times[:-1])
        np.testing.assert_array_equal(contacts(short, middle), contacts(long, middle))
        for a, b in zip(feet_motion(short, middle), feet_motion(long, middle), strict=True):
            np.testing.assert_array_equal(a, b)
        n = int(short.pieces)
        np.testing.assert_array_equal(short.dcm[:n], long.dcm[:n])
