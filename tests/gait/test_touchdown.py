"""Where a swing may land and when: what is asked of the step program, and what comes of it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from drake_linefoot.gait.footsteps import StepCommand, heading_vector, swing_duration
from drake_linefoot.gait.recovery import is_insufficient
from drake_linefoot.gait.state import PITCH, YAW, Z
from drake_linefoot.gait.step_program import Step
from drake_linefoot.gait.swing import base_motion, swing_motion
from drake_linefoot.gait.swing_foot import present_swing, retime_step
from drake_linefoot.gait.touchdown import (
    ends_beside,
    foot_acceleration,
    place_beside,
    planned_height,
    soonest,
    step_problem,
    update_foothold,
)
from drake_linefoot.math.splines import bump
from tests.helpers.phases import phase_end, planned_touchdown, set_swing, swing_of
from tests.helpers.steps import OFFSET, OMEGA, SCALE, SHAPE, ZERO, T, constants, swing_state

WALK = StepCommand(np.array([0.4, -0.1]), 0.3, T)
SIDES = [0, 1]
FLAT = np.zeros(2)
SAMPLES = 2001  # of a motion: its peak is found to within 1e-5


def swinging(side=0, elapsed=0.12, length=0.2, command=WALK, yaw=0.4):
    """A foot in the air over level ground, in full motion, `elapsed` after it was lifted."""
    com, stance = np.array([0.32, -0.17]), np.array([0.3, -0.2])
    case = com, np.array([0.5, 0.1]), stance, yaw, side, command
    s = swing_state(case, height=0.02, slope=FLAT)
    s.clock.time = 5.0
    set_swing(s, 5.0 - elapsed, 5.0 - elapsed + length)
    s.robot.pendulum_velocity[:] += [0.03, -0.02, 0.0]
    aside = (0.16, -0.16)[side]
    swing_of(s).reference[0] = [*stance + heading_vector(yaw, -0.05, aside), 0.05, 0.0, yaw]
    swing_of(s).reference[1], swing_of(s).reference[2] = (
        [1.5, 0.2, -0.1, 0.1, 0.3],
        [-4.0, 1.0, 2.0, 0.0, 1.0],
    )
    swing_of(s).target[:] = [*stance + heading_vector(yaw, 0.09, aside), 0.02, 0.0, yaw]
    return s


def peak(start, goal, duration):
    """The largest acceleration of a quintic from rest to rest [m/s^2], sampled."""
    reference, target = np.zeros((3, 5)), np.zeros(5)
    reference[0, 0], target[0] = start, goal
    times = np.linspace(0.0, duration, SAMPLES)
    return np.abs(base_motion(reference, target, duration, times)[2, :, 0]).max()


def flight(s, c, n=41):
    """The rest of a swing, sampled: position, velocity and acceleration, shape (3, n, 5)."""
    return swing_motion(
        present_swing(s, 1 - int(s.clock.side), c), np.linspace(s.clock.time, phase_end(s), n)
    )


# --- how soon ------------------------------------------------------------------------------


@pytest.mark.parametrize("settle", [0.006, 0.03])
def test_a_foot_that_lands_soonest_comes_down_as_hard_as_its_leg_can(settle):
    """It is down, but for the bump, `settle_time` before its touchdown, like all of a swing."""
    s, c = swinging(elapsed=0.1), constants(SHAPE, settle_time=settle, swing_time_min=0.0)
    above = planned_height(s, 0)[0]
    assert above > 0.05
    soon = soonest(s, 0, c)
    assert peak(above, 0.0, soon - settle) == pytest.approx(c.swing_acceleration[2], rel=1e-5)
    s.recovery.steps = 2  # and then less
    assert soon - soonest(s, 0, c) == pytest.approx(settle - c.settle_time_min)


def test_a_foot_that_has_just_been_lifted_is_lifted_as_a_swing_of_its_height_takes():
    """Of swings of another height the shortest has the same acceleration of its bump."""
    s = swinging(elapsed=0.01)
    swing_of(s).reference[0, Z], swing_of(s).reference[1, Z] = 0.02, 0.0
    for higher in (1.0, 2.0):
        s.swing.height[:] = higher * SHAPE.swing_height
        shortest = soonest(s, 0, SHAPE) + 0.01
        times = np.linspace(0.0, shortest, SAMPLES)
        most = np.abs(bump(s.swing.height[0], shortest, times)[2]).max()
        usual = np.linspace(0.0, SHAPE.swing_time_min, SAMPLES)
        expected = np.abs(bump(SHAPE.swing_height, SHAPE.swing_time_min, usual)[2]).max()
        assert most == pytest.approx(expected, rel=1e-6)


def test_a_foot_below_the_ground_that_was_expected_needs_no_time_to_come_down():
    s = swinging(elapsed=0.19)
    swing_of(s).reference[0, Z] = -0.05
    assert planned_height(s, 0)[0] < 0.0
    assert soonest(s, 0, SHAPE) == pytest.approx(SHAPE.settle_time)


@pytest.mark.parametrize("slope", [FLAT, np.array([0.12, -0.07])])
def test_the_planned_height_is_that_of_the_motion_above_the_plane(slope):
    s = swinging()
    s.ground.slope[:] = slope
    position, velocity, _ = flight(s, SHAPE)[:, 0]
    stance = s.robot.feet[int(s.clock.side)]
    ground = stance[2] + slope @ (position[:2] - stance[:2])
    assert planned_height(s, 0) == pytest.approx((position[Z] - ground, velocity[Z]), abs=1e-12)


# --- another time --------------------------------------------------------------------------


@pytest.mark.parametrize("change", [-0.03, -0.01, 0.02, 0.05])
def test_another_touchdown_bends_the_motion_without_a_jump(change):
    """Neither place, velocity nor acceleration jumps, and the foot comes down at the new time."""
    s = swinging()
    before, height = flight(s, SHAPE)[:, 0], s.swing.height.copy()
    end = phase_end(s) + change
    retime_step(s, 0, end)
    assert (phase_end(s), planned_touchdown(s)) == (end, end)
    np.testing.assert_array_equal(s.swing.height, height)
    motion = flight(s, SHAPE)
    np.testing.assert_allclose(motion[:, 0], before, atol=1e-11)
    np.testing.assert_allclose(motion[0, -1], swing_of(s).target, atol=1e-11)
    np.testing.assert_allclose(motion[1, -1], 0.0, atol=1e-9)


# --- how hard ------------------------------------------------------------------------------


@pytest.mark.parametrize("forward", [0.5, -1.6])
@pytest.mark.parametrize("recovering", [0, 2])
def test_a_steady_walk_is_not_held_back_by_the_acceleration_of_its_foot(forward, recovering):
    """The bound is the peak of the quintic that takes a foot as far as two steps go."""
    s, c = swinging(), constants(SHAPE, swing_acceleration=[1e-3] * 3, step_length=0.28)
    s.command.velocity[:], s.recovery.steps = [forward, 0.2], recovering
    swing = swing_duration(s, c)
    assert (swing < c.single_support) == (abs(forward) > 1.3)
    way = 2.0 * (s.command.velocity * SCALE + OFFSET) * (swing + c.double_support)
    left = swing - (c.settle_time_min if recovering else c.settle_time)
    expected = [peak(0.0, w, left) for w in way]
    np.testing.assert_allclose(foot_acceleration(s, c), expected, rtol=1e-5)
    strong = constants(c, swing_acceleration=[expected[0] + 1.0, expected[1] - 1.0, 1.0])
    np.testing.assert_allclose(
        foot_acceleration(s, strong), [expected[0] + 1.0, expected[1]], rtol=1e-5
    )


# --- what is asked -------------------------------------------------------------------------


@pytest.mark.parametrize("side", SIDES)
def test_the_problem_is_the_swing_in_the_frame_of_the_stance_foot(side):
    s, yaw = swinging(side), 0.7
    x, stance = step_problem(s, side, yaw, 0, SHAPE), s.robot.feet[1 - side, :2]
    R = Rotation.from_euler("z", yaw).as_matrix()[:2, :2]
    turned = R @ np.diag([1.0, (1.0, -1.0)[side]])  # ahead, and outward to the swing foot

    def seen(vector):
        return turned.T @ vector

    # Of the pendulum with the angular momentum; of the CoM, which has to be reached, without.
    np.testing.assert_allclose(
        x.dcm, seen(s.robot.com[:2] + s.robot.pendulum_velocity[:2] / OMEGA - stance)
    )
    np.testing.assert_allclose(x.com, seen(s.robot.com[:2] - stance))
    np.testing.assert_allclose(x.com_velocity, seen(s.robot.com_velocity[:2]))
    np.testing.assert_allclose(x.foot, seen(swing_of(s).reference[0, :2] - stance))
    np.testing.assert_allclose(x.foot_velocity, seen(swing_of(s).reference[1, :2]))
    np.testing.assert_allclose(x.target, seen(swing_of(s).target[:2] - stance))
    # The offset of a steady walk that begins with the foot that lands: strides lead away from it.
    v, turn = s.command.velocity * SCALE + OFFSET, s.command.turn_rate * T
    feet, path = [], np.zeros(2)
    for k in range(60):
        h = yaw + k * turn
        aside = (0.5, -0.5)[(side + k) % 2] * max(SHAPE.step_width, 0.1 + abs(v[1] * T))
        feet.append(path + heading_vector(h, 0.0, aside))
        path = path + heading_vector(h + 0.5 * turn, *v * T)
    strides = np.diff(feet, axis=0)
    offset = np.exp(-OMEGA * T * np.arange(1, 60)) @ strides
    np.testing.assert_allclose(x.offset, seen(offset), atol=2e-3)


@pytest.mark.parametrize("length", [0.195, 0.25, 0.28])
@pytest.mark.parametrize("elapsed", [0.01, 0.12, 0.19])
def test_the_times_of_a_problem_count_from_now(elapsed, length):
    """A swing of 0.2 s that is planned to last `length`; one that is lost 1.3 times as long."""
    s = swinging(elapsed=elapsed, length=length)
    x = step_problem(s, 0, s.command.yaw, 0, SHAPE)
    assert x.planned == pytest.approx(length - elapsed)
    assert x.nominal == pytest.approx(0.2 - elapsed)
    assert x.longest == pytest.approx(max(0.2, length) - elapsed)
    assert x.latest == pytest.approx(max(0.26, length) - elapsed)
    assert x.shortest == pytest.approx(min(soonest(s, 0, SHAPE), length - elapsed))
    assert (x.switch, x.settle) == (SHAPE.switch, SHAPE.settle_time)
    s.recovery.steps = 1
    x = step_problem(s, 0, s.command.yaw, 0, SHAPE)
    assert (x.switch, x.settle) == (SHAPE.switch_min, SHAPE.settle_time_min)


def test_at_speed_a_swing_is_as_short_as_its_step_length_makes_it():
    """0.28 m at 1.6 m/s are 0.175 s, 30 ms of them on both feet; phases last whole 2 ms."""
    s, c = swinging(elapsed=0.05, length=0.1), constants(SHAPE, step_length=0.28)
    s.command.velocity[:] = [1.6, 0.3]
    x = step_problem(s, 0, s.command.yaw, 0, c)
    assert x.nominal == pytest.approx(0.145 - 0.05, abs=1.001e-3)
    assert x.latest == pytest.approx(1.3 * (x.nominal + 0.05) - 0.05)


def test_a_touchdown_that_is_planned_sooner_than_a_foot_comes_down_stays_possible():
    s = swinging(elapsed=0.12, length=0.14)
    x = step_problem(s, 0, s.command.yaw, 0, SHAPE)
    assert x.shortest == pytest.approx(0.02)
    assert soonest(s, 0, SHAPE) > 0.03


# --- what comes of it ----------------------------------------------------------------------


@pytest.mark.parametrize("side", SIDES)
def test_a_walk_ends_beside_the_stance_foot(side):
    s, command = swinging(side), StepCommand(ZERO, 0.0, T)
    s.command.velocity[:], s.command.turn_rate = command.velocity, command.turn_rate
    place = place_beside(s, side, SHAPE)
    way = heading_vector(-s.command.yaw, *(place - s.robot.feet[1 - side, :2]))
    np.testing.assert_allclose(way, [0.0, (0.16, -0.16)[side]], atol=1e-12)
    for way in ([1.0, 0.0], [0.0, -1.0], [-0.6, 0.8]):
        for off in (0.039, 0.041):
            swing_of(s).target[:2] = place + off * np.array(way)
            assert ends_beside(s, side, SHAPE) == (off < SHAPE.final_step_tolerance)
    swing_of(s).target[:2] = place
    for name, value in (("velocity", [0.1, 0.0]), ("velocity", [0.0, 0.1]), ("turn_rate", 0.1)):
        moving = s.copy()
        moving["command"][name] = value
        assert not ends_beside(moving, side, SHAPE)
    s.clock.queued = 0.0
    s.command.turn_rate = 0.5
    before, end = s.copy(), phase_end(s)
    assert not update_foothold(s, side, SHAPE)
    np.testing.assert_allclose(swing_of(s).target[:2], place, atol=1e-12)
    assert swing_of(s).target[YAW] == pytest.approx(
        s.command.yaw + 0.5 * (end - s.clock.time + 0.5 * T)
    )
    assert (phase_end(s), s.recovery.moved_footholds, s.recovery.steps) == (
        end,
        before.recovery.moved_footholds,
        0,
    )


@pytest.mark.parametrize("side", SIDES)
def test_a_push_makes_the_step_sooner_and_recovery_steps_follow_it(side):
    """To the heading of the new time, on the plane through the stance foot."""
    s = swinging(side, elapsed=0.03)
    swing_of(s).reference[0, Z], swing_of(s).reference[1:] = 0.02, 0.0
    swing_of(s).reference[0, YAW] += 2.0 * np.pi  # the foot does not turn back by it
    s.ground.slope[:] = [0.1, 0.05]
    s.robot.pendulum_velocity[:2] += heading_vector(s.command.yaw, 0.0, (1.0, -1.0)[side])
    before, planned = flight(s, SHAPE)[:, 0], phase_end(s)
    assert update_foothold(s, side, SHAPE)
    assert phase_end(s) < planned - 0.01
    assert (s.recovery.moved_footholds, s.recovery.steps) == (1, SHAPE.recovery_steps)
    heading = s.command.yaw + s.command.turn_rate * (phase_end(s) - s.clock.time + 0.5 * T)
    assert swing_of(s).target[YAW] == pytest.approx(heading + 2.0 * np.pi, abs=1e-12)
    away, stance = swing_of(s).target[:2] - s.robot.feet[1 - side, :2], s.robot.feet[1 - side]
    assert swing_of(s).target[Z] == pytest.approx(stance[2] + s.ground.slope @ away, abs=1e-12)
    assert np.tan(swing_of(s).target[PITCH]) == pytest.approx(
        -s.ground.slope @ heading_vector(heading, 1.0, 0.0)
    )
    np.testing.assert_allclose(flight(s, SHAPE)[:, 0], before, atol=1e-11)


@given(st.floats(0.02, 0.3), st.sampled_from([(0, 1), (0, -1), (1, 1), (1, -1)]))
def test_what_comes_short_is_measured_at_the_switch_of_the_weight(time, way):
    """Against a DCM that is integrated until then."""
    s = swinging()
    x = step_problem(s, 0, s.command.yaw, 0, SHAPE)
    until = time + SHAPE.switch
    landing = x.dcm * np.exp(OMEGA * until)
    i, sign = way
    for off, short in ((0.99, False), (1.01, True)):
        foothold = landing - x.offset
        foothold[i] += sign * off * SHAPE.short_step
        assert is_insufficient(x, Step(time, foothold, True, 0.0, False), SHAPE) == short
