"""Contacts in time: a foot stands from its touchdown to the next one's plus d, whatever d is."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_linefoot.gait.clock import (
    advance_clock,
    delay_touchdown,
    end_walk,
    land_foot,
    lift_foot,
    load_foot,
    plan_touchdown,
    stand_still,
)
from drake_linefoot.gait.contacts import (
    in_contact,
    in_double_support,
    in_final_step,
    is_stepping,
    standing_still,
)
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.gait.schedule import contacts, feet_motion
from drake_linefoot.gait.state import ENDLESS, PITCH, new_state
from drake_linefoot.gait.swing_foot import begin_swing
from drake_linefoot.parts import FOREVER
from drake_linefoot.statuses import Mode
from tests.helpers.horizons import horizon_at, phases_of
from tests.helpers.pendulum_robot import STAND_STILL, PendulumRobot
from tests.helpers.phases import contact_of, mode_of
from tests.helpers.steps import constants

SWING = 0.23  # [s] of a foot in the air


def standing():
    s = new_state()
    s.clock.touchdown[:], s.clock.lift_off[:] = -1.0, FOREVER
    return s


def stands(touchdowns, first, overlap, foot, time):
    """Whether a foot stands, from the definition: `first` landed at the first of them."""
    landed = [k for k in range(len(touchdowns)) if (first + k) % 2 == foot]
    return any(
        touchdowns[k] <= time and (k + 1 == len(touchdowns) or time < touchdowns[k + 1] + overlap)
        for k in landed
    )


# --- events ----------------------------------------------------------------------------------


def walk_by_the_clock(first, overlap, count):
    """Contacts of a clock over time, and the touchdowns it went through.

    It is told when feet are lifted and land, nothing else; its plans say when that is.
    """
    s, dt, seen, touchdowns = standing(), 0.001, [], [0.0]
    load_foot(s, first, 0.0, overlap)
    if overlap < 0.0:  # as in the air: the other foot was lifted before
        s.clock.lift_off[1 - first], s.clock.touchdown[1 - first] = overlap, overlap + SWING
        s.clock.lift_off[first] = SWING + 2.0 * overlap
    while len(touchdowns) < count:
        advance_clock(s, s.clock.time + dt)
        for foot in (0, 1):
            if not in_contact(s, foot) and s.clock.time >= s.clock.touchdown[foot] - 1e-9:
                land_foot(s, foot, foot, overlap)
                touchdowns.append(s.clock.time)
        for foot in (0, 1):
            if in_contact(s, foot) and s.clock.time >= s.clock.lift_off[foot] - 1e-9:
                lift_foot(s, foot, SWING)
        seen.append((s.clock.time, *contact_of(s)))
    return seen[:-1], touchdowns


@pytest.mark.parametrize("first", [0, 1])
@pytest.mark.parametrize("overlap", [0.03, 0.001, 0.0, -0.01, -0.06])
def test_contacts_of_the_clock_are_those_of_touchdowns_and_d(first, overlap):
    """d above 0 never lets both feet swing, d below 0 never lets both stand."""
    seen, touchdowns = walk_by_the_clock(first, overlap, 8)
    np.testing.assert_allclose(np.diff(touchdowns), SWING + overlap, atol=0.0021)
    before = [-1.0, *touchdowns]  # of the other foot
    for time, *contact in seen:
        expected = [stands(before, 1 - first, overlap, foot, time + 1e-6) for foot in (0, 1)]
        if min(abs(time - t - d) for t in touchdowns for d in (0.0, overlap)) > 0.0015:
            assert contact == expected
    both = {sum(contact) for _, *contact in seen}
    assert both == ({1, 2} if overlap > 0.0 else {1} if overlap == 0.0 else {0, 1})


@given(st.integers(0, 1), st.floats(0.001, 0.1), st.floats(-0.05, 0.05))
def test_the_standing_foot_waits_for_a_touchdown_that_comes_later_or_sooner(side, overlap, change):
    s = standing()
    load_foot(s, side, 0.0, overlap)
    assert s.clock.lift_off[1 - side] == overlap
    advance_clock(s, overlap)
    lift_foot(s, 1 - side, SWING)
    assert contact_of(s) == (side == 0, side == 1)
    assert s.clock.lift_off[side] == overlap + SWING + overlap
    plan_touchdown(s, 1 - side, overlap + SWING + change)
    assert s.clock.planned_touchdown[1 - side] == overlap + SWING + change
    delay_touchdown(s, 1 - side, overlap + SWING + 0.1)
    assert s.clock.planned_touchdown[1 - side] == overlap + SWING + change
    assert s.clock.lift_off[side] == pytest.approx(2.0 * overlap + SWING + 0.1, abs=1e-12)
    assert in_contact(s, side)


def test_standing_has_no_end_and_ends_a_wait_for_the_first_step():
    s = standing()
    assert standing_still(s) and not is_stepping(s)
    load_foot(s, 1, 0.4, 0.03)
    assert in_double_support(s) and not standing_still(s) and not is_stepping(s)
    assert mode_of(s) == Mode.SHIFT
    advance_clock(s, 0.2)
    stand_still(s)
    assert standing_still(s) and mode_of(s) == Mode.STAND
    assert s.clock.touchdown.max() <= 0.2
    advance_clock(s, 1e6)
    assert standing_still(s)


@pytest.mark.parametrize("side", [0, 1])
def test_a_wait_for_the_first_step_ends_where_the_other_foot_has_to_step_out(side):
    s = standing()
    load_foot(s, 1 - side, 0.4, 0.03)
    advance_clock(s, 0.2)
    load_foot(s, side, 0.2, 0.03)
    assert is_stepping(s) and mode_of(s) == Mode.DOUBLE
    assert s.clock.touchdown.max() == 0.2
    assert s.clock.lift_off[1 - side] == pytest.approx(0.23)


@pytest.mark.parametrize("first", ["left", "right"])
@pytest.mark.parametrize("speed", [-0.7, 0.7])
def test_a_push_in_the_weight_shift_makes_it_step_out_to_its_side(first, speed):
    """With the foot of that side, after a double support, whichever was to step first."""
    robot = PendulumRobot(GaitParameters(first_swing=first))
    robot.run([0.0, 0.0, 0.0, 1.0], 0.1)
    assert mode_of(robot.state) == Mode.SHIFT
    robot.com_velocity[1] += speed
    ticks = robot.run([0.0, 0.0, 0.0, 1.0], 0.05)
    names = [mode_of(t.state) for t in ticks]
    both = round(robot.parameters.double_support / 0.001)
    assert names[0] == Mode.DOUBLE and names.count(Mode.DOUBLE) == both
    assert set(names[both:]) == {Mode.SWING}
    assert contact_of(ticks[-1].state) == ((True, False) if speed < 0.0 else (False, True))


@pytest.mark.parametrize("side", [0, 1])
def test_the_final_step_is_one_after_which_none_is_queued(side):
    s = standing()
    load_foot(s, side, 0.0, 0.03)
    assert (mode_of(s), s.clock.queued) == (Mode.DOUBLE, ENDLESS)
    lift_foot(s, 1 - side, SWING)
    end_walk(s, False)
    assert not in_final_step(s)
    end_walk(s, True)
    assert in_final_step(s) and s.clock.lift_off[side] == FOREVER
    delay_touchdown(s, 1 - side, 1.0)
    assert s.clock.lift_off[side] == FOREVER


def test_people_call_two_feet_in_the_air_a_flight():
    s = standing()
    load_foot(s, 0, 0.0, -0.06)
    lift_foot(s, 1, SWING)
    assert mode_of(s) == Mode.SWING
    lift_foot(s, 0, SWING)
    assert (mode_of(s), contact_of(s)) == (Mode.FLIGHT, (False, False))


# --- horizons --------------------------------------------------------------------------------


def state_of(overlap, at):
    """A state at `at` [s] of a walk or run whose left foot lands at 0, and its constants."""
    robot = PendulumRobot()
    c = constants(robot.constants, double_support=overlap, single_support=SWING, step_length=9.0)
    s, step = robot.state.copy(), SWING + overlap
    k = int(at // step)  # of the last touchdown
    s.clock.time, s.clock.side, s.clock.queued, s.clock.overlap = at, k % 2, ENDLESS, overlap
    for foot in (0, 1):
        last = k if k % 2 == foot else k - 1
        lift = (last + 1) * step + overlap
        swings = at >= lift
        s.clock.touchdown[foot] = (last + 2 if swings else last) * step
        s.clock.lift_off[foot] = lift
        if swings:
            s.clock.side = 1 - foot
            begin_swing(s, foot, c)
            s.swing.reference[foot, 0, 0] += 0.1
            s.swing.target[foot, 0] += 0.1
    if contact_of(s) == (False, False):
        s.clock.side = int(np.argmin(s.clock.touchdown))
    s.clock.planned_touchdown[:] = s.clock.touchdown
    return s, c


@pytest.mark.parametrize("overlap", [0.03, 0.0, -0.03, -0.06])
@pytest.mark.parametrize("at", [0.41, 0.45, 0.5, 0.53, 0.57, 0.62])
def test_contacts_of_a_horizon_are_those_of_touchdowns_and_d(overlap, at):
    """Sampled; every foot that is in the air has a swing, and moves without a jump."""
    s, c = state_of(overlap, at)
    length, step = 0.8, SWING + overlap
    horizon = horizon_at(s, c, length)
    touchdowns = step * np.arange(0, 12)
    times = at + np.arange(0.0, length, 0.0005) + 1e-5
    off = np.abs(times[:, None, None] - touchdowns[:, None] - [0.0, overlap]).min(axis=(1, 2))
    expected = [[stands(touchdowns, 0, overlap, foot, t) for foot in (0, 1)] for t in times]
    clear = off > 1e-6
    np.testing.assert_array_equal(contacts(horizon, times)[clear], np.array(expected)[clear])
    phases = phases_of(horizon)
    assert phases[0].start == at and phases[-1].end >= at + length - 1e-9
    for a, b in pairwise(phases):
        assert a.end == b.start < b.end
    feet = feet_motion(horizon, times).position
    assert np.abs(np.diff(feet, axis=1))[:, :, :PITCH].max() < 0.01
    landings = sorted({(w.end, i) for p in phases for i, w in enumerate(p.swings) if w})
    assert horizon.coming == len(landings)
    for (_, side), (_, other) in pairwise(landings):
        assert side != other


@pytest.mark.parametrize("overlap", [0.03, -0.06])
def test_a_swing_is_the_same_in_every_phase_over_which_it_goes(overlap):
    s, c = state_of(overlap, 0.45)
    phases = phases_of(horizon_at(s, c, 0.8))
    together = [p for p in phases if p.swings[0] and p.swings[1]]
    assert bool(together) == (overlap < 0.0)
    for side in (0, 1):
        known = {}
        for p in phases:
            if p.swings[side]:
                first = known.setdefault(p.swings[side].end, p.swings[side])
                for a, b in zip(first, p.swings[side], strict=True):
                    np.testing.assert_array_equal(a, b)
                assert p.swings[side].start <= p.start < p.end <= p.swings[side].end
        assert len(known) >= 2


def test_a_robot_that_stands_has_one_phase_without_end():
    robot = PendulumRobot()
    robot.run(STAND_STILL, 0.01)
    (phase,) = phases_of(horizon_at(robot.state, robot.constants, 0.5))
    assert (phase.contact, phase.end) == ((1.0, 1.0), FOREVER)
