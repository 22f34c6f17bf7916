"""The state machine of the gait and where it places the feet, on a pendulum."""

from itertools import groupby

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_linefoot.gait.footsteps import heading_vector, nearest_turn
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.parts import FOREVER
from drake_linefoot.statuses import Mode
from tests.helpers.pendulum_robot import DT, STAND_STILL, PendulumRobot, landed
from tests.helpers.phases import contact_of, mode_of, phase_start, swing_of
from tests.helpers.walking import mirror_places

IN_PLACE = [0.0, 0.0, 0.0, 1.0]


def phases(ticks):
    """The modes and sides one after the other, with their length in ticks."""
    keys = groupby(ticks, key=lambda t: (Mode(mode_of(t.state)).name, t.state.clock.side))
    return [(mode, side, len(list(group))) for (mode, side), group in keys]


def mean_velocity(ticks, steps=4):
    """Mean CoM velocity over the last `steps` steps, in the mean heading, and turn rate."""
    ends = [
        k
        for k in range(1, len(ticks))
        if ticks[k].state.clock.steps != ticks[k - 1].state.clock.steps
    ]
    a, b = ticks[ends[-1 - steps]].state, ticks[ends[-1]].state
    T = b.clock.time - a.clock.time
    velocity = heading_vector(
        -0.5 * (a.command.yaw + b.command.yaw), *(b.robot.com - a.robot.com)[:2] / T
    )
    return velocity, (b.command.yaw - a.command.yaw) / T


# --- sequence ---------------------------------------------------------------------------


@pytest.mark.parametrize(("first", "stance"), [("right", 0), ("left", 1)])
def test_a_walk_goes_from_stand_over_shift_to_alternating_steps(first, stance):
    robot = PendulumRobot(GaitParameters(first_swing=first))
    ticks = robot.run(STAND_STILL, 0.05) + robot.run(IN_PLACE, 1.5)
    other = 1 - stance
    assert phases(ticks)[:7] == [
        ("STAND", stance, 50),
        ("SHIFT", stance, 400),
        ("DOUBLE", stance, 30),
        ("SWING", stance, 200),
        ("DOUBLE", other, 30),
        ("SWING", other, 200),
        ("DOUBLE", stance, 30),
    ]
    for tick in ticks:
        state = tick.state
        stands, side = contact_of(state), int(state.clock.side)
        assert stands[side]
        assert stands[1 - side] == (mode_of(state) != Mode.SWING)


def test_a_walk_ends_standing_with_the_feet_beside_each_other():
    robot = PendulumRobot()
    ticks = robot.run([0.6, 0.0, 0.4, 1.0], 3.0) + robot.run(STAND_STILL, 4.0)
    modes = [mode for mode, _, _ in phases(ticks)]
    assert modes[-2:] == ["SWING", "STAND"]
    end = ticks[-1].state
    assert end.clock.queued == 0.0
    between = heading_vector(-end.command.yaw, *(end.robot.feet[0] - end.robot.feet[1])[:2])
    np.testing.assert_allclose(between, [0.0, 0.16], atol=1e-9)
    np.testing.assert_allclose(end.robot.feet[:, 3], nearest_turn(end.command.yaw, 0.0), atol=1e-9)
    np.testing.assert_allclose(end.robot.com[:2], end.robot.feet[:, :2].mean(axis=0), atol=1e-3)
    np.testing.assert_allclose(end.robot.com_velocity, 0.0, atol=3e-3)
    steps_after = end.clock.steps - ticks[2999].state.clock.steps
    assert steps_after <= 8  # 0.6 s to slow down, then a few steps


def test_a_command_taken_back_during_the_shift_ends_it_without_a_step():
    robot = PendulumRobot()
    robot.run(IN_PLACE, 0.2)
    ticks = robot.run(STAND_STILL, 2.0)
    assert {mode_of(t.state) for t in ticks} == {Mode.STAND}
    assert ticks[-1].state.clock.steps == 0
    np.testing.assert_allclose(ticks[-1].state.robot.com[:2], 0.0, atol=2e-3)


def test_a_robot_commanded_to_stand_never_moves():
    ticks = PendulumRobot(yaw=0.4).run(STAND_STILL, 0.5)
    end = ticks[-1].state
    assert mode_of(end) == Mode.STAND
    assert end.command.yaw == pytest.approx(0.4, abs=1e-12)
    np.testing.assert_array_equal(end.clock.lift_off, FOREVER)


# --- commands ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    "command",
    [[0.8, 0.0, 0.0], [0.3, -0.2, 0.0], [-0.4, 0.0, 0.6], [0.0, 0.5, 0.0]],
)
def test_it_walks_at_the_commanded_velocity(command):
    """Learning makes up for what the series and the lean into a turn take away."""
    ticks = PendulumRobot().run([*command, 1.0], 7.0)
    velocity, turn_rate = mean_velocity(ticks)
    np.testing.assert_allclose(velocity, command[:2], atol=0.02)
    assert turn_rate == pytest.approx(command[2], abs=1e-9)


@pytest.mark.parametrize("turn_rate", [2.0, -2.0])
def test_it_turns_more_than_once_round_and_the_feet_never_spin(turn_rate):
    """Measured headings jump by a whole turn; the swing must not."""
    ticks = PendulumRobot(yaw=2.9).run([0.2, 0.0, turn_rate, 1.0], 5.0)
    assert abs(ticks[-1].state.command.yaw - 2.9) > 2.0 * np.pi
    rates = [t.foot.velocity[0, 4] for t in ticks if t.foot is not None]
    # A foot turns 2 w T = 0.92 rad in 0.17 s, at about twice the mean rate at most; a whole
    # turn more would be 70 rad/s.
    assert np.abs(rates).max() < 15.0
    for state in (t.state for t in ticks if mode_of(t.state) == Mode.SWING):
        # Ahead of the torso by what it turns until the middle of the next stance: 0.63 rad.
        assert (
            abs(nearest_turn(swing_of(state).target[4], state.command.yaw) - state.command.yaw)
            < 0.65
        )


def test_velocity_follows_the_command_at_limited_rates():
    p = GaitParameters()
    robot = PendulumRobot()
    ticks = robot.run([1.2, -0.4, 1.8, 1.0], 2.0) + robot.run([-0.5, 0.4, -1.8, 1.0], 3.0)
    v = np.array([[*t.state.command.velocity, t.state.command.turn_rate] for t in ticks])
    slope = np.abs(np.diff(v, axis=0)).max(axis=0) / DT
    limits = [p.linear_acceleration, p.linear_acceleration, p.angular_acceleration]
    np.testing.assert_allclose(slope, limits, rtol=1e-9)
    np.testing.assert_allclose(v[1990], [1.2, -0.4, 1.8], atol=1e-12)
    np.testing.assert_allclose(v[-1], [-0.5, 0.4, -1.8], atol=1e-12)
    yaw = np.array([t.state.command.yaw for t in ticks])
    np.testing.assert_allclose(np.diff(yaw), v[1:, 2] * DT, atol=1e-12)


@pytest.mark.parametrize("walk", [0.0, 1.0])
def test_a_command_outside_its_limits_is_clipped_and_counted(walk):
    robot = PendulumRobot()
    robot.run([2.6, 0.5, 2.0, walk], 0.03)
    assert robot.state.command.clipped == 0  # at the limits
    robot.run([2.7, 0.0, 0.0, walk], 0.02)
    robot.run([0.0, -0.6, 0.0, walk], 0.01)
    robot.run([0.0, 0.0, 2.1, walk], 0.005)
    assert robot.state.command.clipped == 35


def test_the_velocity_never_exceeds_the_limits():
    """Here those of a walk, with no run that may follow it."""
    ticks = PendulumRobot(GaitParameters(flight=0.0)).run([9.0, -9.0, 9.0, 1.0], 2.5)
    v = np.abs([[*t.state.command.velocity, t.state.command.turn_rate] for t in ticks])
    np.testing.assert_array_equal(v.max(axis=0), [1.5, 0.5, 2.0])


@pytest.mark.parametrize("command", [0.5, 9.0])
def test_the_speed_is_learned_also_when_the_command_is_clipped(command):
    """A scale that starts 20 % too high comes down towards 1; 1.5 m/s is the most it may be."""
    robot = PendulumRobot(GaitParameters(speed_scale=[1.2, 1.0], flight=0.0))
    ticks = robot.run([command, 0.0, 0.0, 1.0], 5.0)
    assert ticks[-1].state.speed.scale[0] == pytest.approx(1.0, abs=0.03)


def test_the_learned_scale_stays_within_its_bounds():
    p = GaitParameters(speed_learning=1.0, speed_scale_max=1.05)
    ticks = PendulumRobot(p).run([0.6, 0.2, 0.5, 1.0], 3.5)
    scales = np.array([t.state.speed.scale for t in ticks[500:] if t.state.clock.steps > 3])
    assert scales.max() <= 1.05 + 1e-12
    assert scales.min() >= 1 / 1.05 - 1e-12


# --- touchdown --------------------------------------------------------------------------


def at_share(touch):
    """Flags of a foot that finds the ground at a share of its swing of 0.2 s."""

    def flags(state):
        if mode_of(state) != Mode.SWING:
            return True, True
        swinging = state.clock.time + DT - phase_start(state) >= touch * 0.2 - 1e-9
        return (True, swinging) if state.clock.side == 0 else (swinging, True)

    return flags


@pytest.mark.parametrize(("touch", "length"), [(0.0, 120), (0.3, 120), (0.7, 140), (1.0, 200)])
def test_early_contact_ends_the_swing_at_once_but_not_before_it_is_believed(touch, length):
    """Contact from the share `touch` of the swing on; 0.6 is where it starts to count."""
    swings = [
        p for p in phases(PendulumRobot().run(IN_PLACE, 1.5, at_share(touch))) if p[0] == "SWING"
    ]
    assert [n for _, _, n in swings[:3]] == [length] * 3


def test_a_flag_of_the_stance_foot_changes_nothing():
    def swing_only(state):
        return tuple(flag and i != state.clock.side for i, flag in enumerate(landed(state)))

    ticks = PendulumRobot().run(IN_PLACE, 1.2)
    other = PendulumRobot().run(IN_PLACE, 1.2, swing_only)
    assert phases(ticks) == phases(other)


def test_a_foothold_out_of_reach_is_moved_and_counted():
    robot = PendulumRobot()
    robot.run([0.3, 0.0, 0.0, 1.0], 1.45)
    assert robot.state.recovery.moved_footholds == 0
    robot.com_velocity[0] += 1.5  # a push
    ticks = robot.run([0.3, 0.0, 0.0, 1.0], 0.3)
    assert ticks[-1].state.recovery.moved_footholds > 0
    for t in ticks:
        if mode_of(t.state) == Mode.SWING:
            reach = np.linalg.norm(
                swing_of(t.state).target[:2] - t.state.robot.feet[int(t.state.clock.side), :2]
            )
            assert reach <= np.hypot(0.5, 0.45) + 1e-9


def test_a_foot_counts_as_standing_where_it_is_from_the_tick_it_lands():
    """Not where it was lifted, one stride behind: the MPC may plan in that very tick."""
    robot = PendulumRobot()
    landings = 0
    for _ in range(1500):
        before = robot.state
        robot.tick([0.6, 0.0, 0.5, 1.0], landed(before))
        stands = list(contact_of(robot.state))
        np.testing.assert_array_equal(robot.state.robot.feet[stands], robot.measure().feet[stands])
        landings += robot.state.clock.steps - before.clock.steps
    assert landings == 4


def test_a_swing_foot_lands_at_the_height_of_the_stance_foot():
    robot = PendulumRobot()
    robot.feet[:, 2] = 0.03
    ticks = robot.run([0.3, 0.0, 0.0, 1.0], 1.5)
    heights = [swing_of(t.state).target[2] for t in ticks if mode_of(t.state) == Mode.SWING]
    np.testing.assert_allclose(heights, 0.03, atol=1e-12)


# --- symmetry ---------------------------------------------------------------------------


def test_a_mirrored_walk_is_the_mirror_image():
    flip = np.array([1.0, -1.0, -1.0, 1.0])
    command = np.array([0.5, 0.2, 0.7, 1.0])
    right = PendulumRobot(GaitParameters(first_swing="right"), yaw=0.2).run(command, 1.3)
    left = PendulumRobot(GaitParameters(first_swing="left"), yaw=-0.2).run(command * flip, 1.3)
    for a, b in zip(right, left, strict=True):
        assert (mode_of(a.state), a.state.clock.side) == (
            mode_of(b.state),
            1 - b.state.clock.side,
        )
        np.testing.assert_allclose(b.state.robot.com, a.state.robot.com * [1, -1, 1], atol=1e-9)
        np.testing.assert_allclose(
            b.state.robot.feet, mirror_places(a.state.robot.feet)[::-1], atol=1e-9
        )
        if a.foot is not None:
            expected = a.foot.position * [1, -1, 1, 1, -1]
            np.testing.assert_allclose(b.foot.position, expected, atol=1e-9)


@given(st.floats(-30.0, 30.0), st.floats(-30.0, 30.0))
def test_nearest_turn_is_the_same_heading_at_most_half_a_turn_away(yaw, present):
    near = nearest_turn(yaw, present)
    assert abs(near - present) <= np.pi + 1e-9
    assert np.cos(near - yaw) == pytest.approx(1.0, abs=1e-9)
