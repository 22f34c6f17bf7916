"""When a swing foot stands: not while it still falls, and late not for long."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.gait.planner import late_contact_time
from drake_linefoot.gait.state import Z
from drake_linefoot.gait.touchdown import planned_height
from drake_linefoot.statuses import Mode
from tests.helpers.horizons import horizon_at, phases_of
from tests.helpers.pendulum_robot import DT, PendulumRobot, landed
from tests.helpers.phases import (
    contact_of,
    mode_of,
    phase_start,
    planned_touchdown,
    set_swing,
    swing_of,
    targets_of,
)

COMMAND = [0.3, 0.0, 0.4, 1.0]
SPEED, LIMIT, PLANNED = GaitParameters().reach_speed, GaitParameters().late_contact_max, 0.2


def found_at(late):
    """Flags of a foot that finds the ground `late` [s] after the planned time; None: never."""

    def flags(state):
        if late is None or mode_of(state) != Mode.SWING:
            return contact_of(state)
        there = state.clock.time + DT - phase_start(state) >= PLANNED + late - 1e-9
        return tuple(there or stands for stands in contact_of(state))

    return flags


def swings(flags, duration=1.3, **parameters):
    """The ticks of every complete swing, each with the tick of its touchdown."""
    robot = PendulumRobot(GaitParameters(**parameters))
    out, now = [], []
    for tick in robot.run(COMMAND, duration, flags):
        if now or mode_of(tick.state) == Mode.SWING:
            now.append(tick)
        if now and mode_of(tick.state) != Mode.SWING:
            out.append(now)
            now = []
    assert len(out) >= 2
    return robot.constants, out


def length(swing):
    return swing[-1].state.clock.time - swing[0].state.clock.time


@pytest.mark.parametrize("late", [0.0, 0.001, 0.012, LIMIT])
def test_the_foot_stands_from_the_tick_in_which_it_is_found_on_the_ground(late):
    for swing in swings(found_at(late))[1]:
        assert length(swing) == pytest.approx(PLANNED + late, abs=1e-9)


def caught(robot, at):
    """Tick until the first touchdown; the ground holds the swing foot from `at` [s] after it was
    due, and no flag says so. Return the ticks that it took from then on."""
    for _ in range(3000):
        state = robot.state
        swings = mode_of(state) == Mode.SWING
        since = state.clock.time + DT - planned_touchdown(state) if swings else -1.0
        side = 1 - int(state.clock.side)
        flags, height = contact_of(state), robot.feet[side, 2]
        robot.tick(COMMAND, flags, (True, True) if since >= at - 1e-9 else flags)
        if since >= at - 1e-9:
            robot.feet[side, 2] = height
            if mode_of(robot.state) != Mode.SWING:
                return since - at
    raise AssertionError("no touchdown")


@pytest.mark.parametrize("at", [0.0, 0.004, 0.015, 0.022])
def test_a_late_foot_that_does_not_go_down_stands_without_a_flag(at):
    """Once it has had its time to follow; a push may hide the force on it from the estimator."""
    wait = GaitParameters().late_contact_wait
    assert caught(PendulumRobot(), at) == pytest.approx(max(wait - at, 0.0), abs=1.5 * DT)


def test_a_foot_that_hangs_high_above_where_it_should_be_does_not_stand():
    robot = PendulumRobot()
    robot.run(COMMAND, 0.9)
    while mode_of(robot.state) != Mode.SWING:
        robot.tick(COMMAND)
    due, side = planned_touchdown(robot.state), 1 - int(robot.state.clock.side)
    while mode_of(robot.state) == Mode.SWING:
        d = robot.dynamics()
        d.p_WC[side, 2] = 0.05
        robot.advance(COMMAND, d, contact_of(robot.state), robot.state.clock.time + DT)
    assert robot.state.clock.time == pytest.approx(due + LIMIT, abs=1.5 * DT)


@pytest.mark.parametrize("limit", [0.0, 0.01, 0.03])
def test_a_foot_that_finds_no_ground_counts_as_standing_in_the_end(limit):
    for swing in swings(found_at(None), late_contact_max=limit)[1]:
        assert length(swing) == pytest.approx(PLANNED + limit, abs=1e-9)
        end = swing[-1].state
        assert contact_of(end) == (True, True)
        before = swing[-2].state
        assert end.robot.feet[1 - int(before.clock.side), 2] <= -SPEED * (limit - 2 * DT) + 1e-9


def test_without_feedback_a_phase_ends_when_planned():
    for flags in (found_at(None), found_at(0.02), found_at(-0.05), lambda state: (True, True)):
        for swing in swings(flags, contact_feedback=False)[1]:
            assert length(swing) == pytest.approx(PLANNED, abs=1e-9)


def test_a_foot_found_in_time_never_reaches_down():
    for swing in swings(landed)[1]:
        assert length(swing) == pytest.approx(PLANNED, abs=1e-9)
        assert min(swing_of(tick.state).reference[0, Z] for tick in swing[:-1]) > -1e-9


@pytest.mark.parametrize("speed", [SPEED, 1.0])
def test_it_reaches_straight_down_at_the_speed(speed):
    """And the swing foot's target says the same, without what is left of the bump."""
    _, walked = swings(found_at(None), reach_speed=speed)
    for swing in walked:
        due = planned_touchdown(swing[0].state)
        last = next(t.state for t in reversed(swing) if t.state.clock.time < due - 1e-9)
        late = [t.state for t in swing[:-1] if t.state.clock.time >= due - 1e-9]
        assert len(late) == round(LIMIT / DT)
        for k, state in enumerate(late):
            assert planned_touchdown(state) == due
            down = np.array([0.0, 0.0, -speed * DT * (k + 1), 0.0, 0.0])
            reference = swing_of(state).reference
            np.testing.assert_allclose(reference[0], swing_of(last).reference[0] + down, atol=1e-12)
            np.testing.assert_array_equal(reference[1], [0.0, 0.0, -speed, 0.0, 0.0])
            np.testing.assert_array_equal(reference[2], 0.0)
            swing_target = targets_of(state).swing_target(1 - int(state.clock.side))
            np.testing.assert_allclose(swing_target.p_WC, reference[0, :3], atol=1e-12)
            np.testing.assert_allclose(swing_target.v_WC, [0.0, 0.0, -speed], atol=1e-12)
            np.testing.assert_allclose(swing_target.a_WC, 0.0, atol=1e-9)


def test_the_plan_of_a_late_foot_stands_on_it_soon():
    """The MPC must not plan a step of no length, nor wait for a foot that may never land."""
    c, walked = swings(found_at(None))
    for swing in walked:
        for state in (t.state for t in swing[:-1]):
            phases = phases_of(horizon_at(state, c, 0.56))
            assert phases[0].contact == contact_of(state)
            assert phases[1].contact == (True, True)
            if state.clock.time >= planned_touchdown(state) - 1e-9:
                assert phases[0].end - state.clock.time == pytest.approx(0.005, abs=1e-12)
            there = phases[1].feet[1 - int(state.clock.side), :3]
            np.testing.assert_allclose(there, swing_of(state).target[:3], atol=1e-12)


def test_a_late_foot_lets_the_slope_be_learned_from_where_it_is():
    """It ends lower than planned, so the ground falls towards it."""
    _, walked = swings(found_at(0.02))
    before, end = walked[0][-2].state, walked[0][-1].state
    way = (
        end.robot.feet[1 - int(before.clock.side), :3] - end.robot.feet[int(before.clock.side), :3]
    )
    assert way[2] < 0.0
    assert end.ground.slope @ way[:2] < 0.0
    assert np.all(before.ground.slope == 0.0)


# --- what is believed -------------------------------------------------------------------


def touched_at(rate):
    """The state after the first flag of a swing foot at the vertical velocity `rate` [m/s]."""
    robot = PendulumRobot()
    robot.run(COMMAND, 0.43 + 0.15)
    assert mode_of(robot.state) == Mode.SWING
    share = (robot.state.clock.time - phase_start(robot.state)) / PLANNED
    assert share > robot.parameters.early_contact_phase
    d = robot.dynamics()
    d.v_WC[:, 2] = rate
    robot.advance(COMMAND, d, (True, True), robot.state.clock.time + DT)
    return robot.state


@pytest.mark.parametrize("rate", [0.0, -0.09, 0.3])
def test_a_flag_of_a_foot_that_has_stopped_is_believed(rate):
    """The right foot swings; what the stance foot does does not matter."""
    for other in (0.0, -1.0):
        assert mode_of(touched_at([other, rate])) == Mode.DOUBLE


@pytest.mark.parametrize("rate", [-0.11, -0.5, -2.0])
def test_a_flag_of_a_foot_that_goes_down_is_not_believed(rate):
    """A push on the torso looks to the observer like a force on the foot."""
    for other in (0.0, -1.0):
        assert mode_of(touched_at([other, rate])) == Mode.SWING


@pytest.mark.parametrize(
    ("planned", "believed"), [(0.3, False), (0.0, False), (-0.05, False), (-0.3, True)]
)
def test_a_flag_is_not_believed_of_a_foot_that_turns_round_at_its_apex(planned, believed):
    """There is one late in a swing that was made shorter. It has stopped, but nothing holds it."""
    robot = PendulumRobot()
    robot.run(COMMAND, 0.43 + 0.15)
    height, rate = planned_height(robot.state, 1)
    assert height > robot.parameters.late_contact_height
    swing_of(robot.state).reference[1, Z] += planned - rate
    d = robot.dynamics()
    d.v_WC[:] = 0.0
    robot.advance(COMMAND, d, (True, True), robot.state.clock.time + DT)
    assert mode_of(robot.state) == (Mode.DOUBLE if believed else Mode.SWING)


def test_flags_of_a_falling_foot_end_no_swing():
    """It lasts as long as if nothing had been flagged, until the foot comes to rest."""
    robot, lengths = PendulumRobot(), []
    start = None
    while len(lengths) < 2:
        before = robot.state
        robot.tick(COMMAND, (True, True), stopped=(False, False))
        if mode_of(robot.state) == Mode.SWING and mode_of(before) != Mode.SWING:
            start = robot.state.clock.time
        if mode_of(before) == Mode.SWING and mode_of(robot.state) != Mode.SWING:
            lengths.append(robot.state.clock.time - start)
    # Within a few ms of the planned time, where the bump of the swing is nearly level.
    assert min(lengths) > 0.95 * PLANNED
    assert max(lengths) <= PLANNED + 1e-9


# --- how long it is waited for ------------------------------------------------------------


def waited(forward, duration=PLANNED, **parameters):
    """How long a late foot is waited for at a speed [m/s], in a swing planned for `duration`."""
    robot = PendulumRobot(GaitParameters(**parameters))
    state = robot.state
    state.command.velocity[0] = forward
    set_swing(state, 1.0, 1.0 + duration)
    return late_contact_time(state, 1 - int(state.clock.side), robot.constants)


@pytest.mark.parametrize("forward", [0.0, 0.3, -0.8, 1.07])
def test_a_slow_robot_waits_as_long_as_it_may(forward):
    """0.28 m a step, 0.26 s with all the waiting: 1.077 m/s."""
    assert waited(forward) == LIMIT


@pytest.mark.parametrize(
    ("forward", "wait"), [(1.12, 0.02), (-1.12, 0.02), (1.25, 0.0), (9.0, 0.0)]
)
def test_a_fast_robot_does_not_wait_for_a_step_that_gets_too_long(forward, wait):
    assert waited(forward) == pytest.approx(wait, abs=1e-12)


@given(st.floats(-3.0, 3.0), st.floats(0.1, 0.3), st.floats(0.0, 0.1))
def test_the_wait_keeps_a_step_within_its_length_and_knows_no_direction(speed, duration, limit):
    wait = waited(speed, duration, late_contact_max=limit)
    assert wait == waited(-speed, duration, late_contact_max=limit)
    assert 0.0 <= wait <= limit
    p = GaitParameters()
    if wait > 0.0:
        assert abs(speed) * (duration + p.double_support + wait) <= p.step_length + 1e-9
