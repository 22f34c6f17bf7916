"""The swing foot: smooth from lift-off to touchdown, whatever the target does."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from drake_linefoot.gait.footsteps import heading_vector
from drake_linefoot.gait.state import PITCH, SIZE, YAW, Z
from drake_linefoot.gait.swing import (
    LineMotion,
    Swing,
    base_motion,
    line_turn,
    present_line,
    swing_motion,
)
from tests.helpers.pendulum_robot import DT, PendulumRobot
from tests.helpers.phases import swing_of

START = np.array([0.1, -0.08, 0.02, 0.1, 0.4])
TARGET = np.array([0.4, -0.1, 0.05, 0.0, 0.9])
TIMES = np.linspace(1.0, 1.2, 401)


def swing(target=TARGET, settle=0.03, start=START):
    reference = np.zeros((3, SIZE))
    reference[0] = start
    return Swing(1.0, 1.2, 1.0, reference, target, height=0.06, settle=settle)


def motion_of(swing, times):
    return LineMotion(*swing_motion(swing, times))


def base_of(swing, times):
    """The motion without the bump."""
    remaining = swing.end - swing.settle - swing.now
    return base_motion(swing.reference, swing.target, remaining, times - swing.now)


def sequences(ticks):
    """Position, velocity and acceleration of the foot in every complete swing, with targets."""
    out, rows = [], []
    for tick in ticks:
        foot = tick.foot
        if foot is not None:
            row = [
                foot.position[0],
                foot.velocity[0],
                foot.acceleration[0],
                swing_of(tick.state).target,
            ]
            rows.append(np.stack(row))
        elif rows:
            out.append(np.array(rows))
            rows = []
    return out


def pushed_walk(shortest=None):
    """Swings of a walk that speeds up, turns and is pushed while a foot is in the air."""
    robot = PendulumRobot(yaw=3.0)
    if shortest is not None:
        robot.constants["swing_time_min"] = shortest
    ticks = robot.run([0.8, 0.0, 0.8, 1.0], 1.15)
    for push in ([0.1, 0.0], [-0.1, 0.15], [0.05, -0.15]):
        robot.com_velocity[:2] += heading_vector(robot.state.command.yaw, *push)
        ticks += robot.run([0.8, 0.1, 0.8, 1.0], 0.23)
    return sequences(ticks)


@pytest.fixture(scope="module")
def swings():
    """Swings that all last as long as planned: the numbers below are those of 0.2 s."""
    return pushed_walk(shortest=1.0)


@pytest.fixture(scope="module")
def shortened():
    """Swings some of which are made shorter while the foot is in the air."""
    return pushed_walk()


def test_the_targets_of_the_walk_do_move(swings):
    assert len(swings) >= 5
    moved = [np.abs(s[:, 3, :2] - s[0, 3, :2]).max() for s in swings]
    assert max(moved) > 0.05


def test_velocity_and_acceleration_are_derivatives_through_every_retargeting(swings, shortened):
    """Central differences of 1 ms; their error is h^2 / 6 of the third derivative."""
    for s in swings + shortened:
        p, v, a = s[:, 0], s[:, 1], s[:, 2]
        jerk = np.abs(np.diff(a, axis=0)).max() / DT
        np.testing.assert_allclose((p[2:] - p[:-2]) / (2 * DT), v[1:-1], atol=DT**2 * jerk / 3)
        np.testing.assert_allclose((v[2:] - v[:-2]) / (2 * DT), a[1:-1], atol=DT * jerk)


def test_nothing_jumps_through_every_retargeting(swings):
    """A jump of the acceleration would show as one difference that is far above all others."""
    for s in swings:
        assert np.abs(s[:, 2, :3]).max() > 30.0
        assert np.abs(np.diff(s[:, 2, :3], axis=0)).max() < 12.0  # [m/s^2] in 1 ms
        assert np.abs(np.diff(s[:, 1, :3], axis=0)).max() < 0.15
        assert np.abs(np.diff(s[:, 0, :3], axis=0)).max() < 0.005


def test_nothing_jumps_where_a_swing_is_made_shorter(shortened):
    """The height, too: a bump of another duration alone would be a jump of 23 mm and 1.2 m/s.

    The shortest swing has 50 ms for 0.1 m: a jerk of 60 * 0.1 m / (50 ms)^3 = 48 m/s^2 in 1 ms.
    """
    assert min(len(s) for s in shortened) < 180
    for s in shortened:
        assert np.abs(np.diff(s[:, 2, :3], axis=0)).max() < 100.0  # [m/s^2] in 1 ms
        assert np.abs(np.diff(s[:, 1, :2], axis=0)).max() < 0.6
        assert np.abs(np.diff(s[:, 1, Z])).max() < 0.2
        assert np.abs(np.diff(s[:, 0, :2], axis=0)).max() < 0.01
        assert np.abs(np.diff(s[:, 0, Z])).max() < 0.003
        assert s[:, 0, Z].min() > -1e-9
        np.testing.assert_allclose(s[-1, 0], s[-1, 3], atol=1e-5)
        # 6 ms before the touchdown it is above its foothold: in a recovery step
        np.testing.assert_allclose(s[-6:, 0, :2], np.tile(s[-1, 3, :2], (6, 1)), atol=1e-9)


def test_a_swing_starts_and_ends_at_rest_at_its_target(swings):
    for s in swings:
        np.testing.assert_allclose(s[0, 1:3], 0.0, atol=1e-12)  # at lift-off
        last = s[-1]  # 1 ms before touchdown
        np.testing.assert_allclose(
            last[0, [0, 1, PITCH, YAW]], last[3, [0, 1, PITCH, YAW]], atol=1e-9
        )
        assert abs(last[0, Z] - last[3, Z]) < 1e-6
        assert abs(last[1, Z]) < 2e-3
        assert abs(last[2, Z]) < 4.0


def test_the_foot_is_above_its_foothold_for_the_settling_time(swings):
    for s in swings:
        settled = s[-30:, 0, [0, 1, PITCH, YAW]]
        np.testing.assert_allclose(settled, np.tile(settled[-1], (30, 1)), atol=1e-9)
        np.testing.assert_allclose(s[-50:, 3], np.tile(s[-1, 3], (50, 1)), atol=1e-15)  # frozen
        assert s[:, 0, Z].max() == pytest.approx(0.06, abs=1e-3)


def test_yaw_takes_the_short_way(swings):
    """The walk begins at 3 rad and turns over pi, where measured headings jump."""
    for s in swings:
        assert abs(s[-1, 0, YAW] - s[0, 0, YAW]) < 0.6
        assert np.abs(s[:, 1, YAW]).max() < 8.0


# --- one swing --------------------------------------------------------------------------


def test_the_end_is_exact_with_no_velocity_and_no_acceleration():
    motion = motion_of(swing(), np.array([1.2]))
    np.testing.assert_allclose(motion.position[0], TARGET, atol=1e-15)
    np.testing.assert_allclose(motion.velocity, 0.0, atol=1e-12)
    np.testing.assert_allclose(motion.acceleration, 0.0, atol=1e-10)


def test_the_apex_is_the_height_above_the_ground_between():
    level = swing(TARGET * [1, 1, 0, 1, 1] + [0, 0, 0.02, 0, 0], settle=0.0)
    z = motion_of(level, TIMES).position[:, Z]
    assert z.max() == pytest.approx(0.02 + 0.06, abs=1e-9)
    assert z.min() == pytest.approx(0.02, abs=1e-12)


@pytest.mark.parametrize("cut", [1.0, 1.04, 1.11, 1.169, 1.185])
def test_what_the_foot_should_do_now_is_the_swing_at_this_time(cut):
    whole = swing()
    at = np.array([cut])
    motion, base = motion_of(whole, at), base_of(whole, at).reshape(3, SIZE)
    rows = present_line(base, whole.height, np.zeros(2), whole.end - whole.start, cut - whole.start)
    expected = [motion.position[0], motion.velocity[0], motion.acceleration[0]]
    np.testing.assert_allclose(rows[:3], np.array(expected)[:, :3], atol=1e-13)
    np.testing.assert_allclose(rows[3:], line_turn(*expected), atol=1e-13)
    mirrored = present_line(base * [1, -1, 1, 1, -1], 0.06, np.zeros(2), 0.2, cut - 1.0)
    along, across = np.array([1, -1, 1]), np.array([-1, 1, -1])  # vectors, and turns
    np.testing.assert_allclose(mirrored[:4], rows[:4] * along, atol=1e-15)
    np.testing.assert_allclose(mirrored[4:], rows[4:] * across, atol=1e-15)


@pytest.mark.parametrize("cut", [1.0, 1.05, 1.12, 1.169, 1.18])
def test_going_on_from_a_cut_is_the_same_swing(cut):
    whole = swing()
    now = np.array([cut])
    p, v, a = base_of(whole, now)
    rest = Swing(1.0, 1.2, cut, np.stack([p[0], v[0], a[0]]), TARGET, 0.06, 0.03)
    later = np.linspace(cut, 1.2, 50)
    np.testing.assert_allclose(
        motion_of(rest, later).position, motion_of(whole, later).position, atol=1e-10
    )
    np.testing.assert_allclose(
        motion_of(rest, later).acceleration, motion_of(whole, later).acceleration, atol=1e-6
    )


@pytest.mark.parametrize("speed", [0.0, 0.3, -0.3])
@pytest.mark.parametrize("rise", [-0.12, -0.2])
def test_a_foot_that_goes_down_a_step_stays_up_until_its_heel_is_past_the_edge(rise, speed):
    """A foot of 15 cm whose target is 2 cm from the edge, however its height changed before."""
    target, start = np.array([0.25, 0.0, rise, 0.0, 0.0]), np.zeros(SIZE)
    down = swing(target, start=start)._replace(step=-1.0)
    down.reference[1, Z] = speed
    motion = motion_of(down, TIMES)
    edge = target[0] - 0.075 - 0.02
    before = motion.position[:, 0] - 0.075 < edge
    assert motion.position[before, Z].min() > -0.005
    np.testing.assert_allclose(motion.position[-1], target, atol=1e-9)
    rate = np.gradient(motion.position[:, Z], TIMES, edge_order=2)
    np.testing.assert_allclose(motion.velocity[:, Z], rate, atol=0.05)


def test_times_outside_the_swing_hold_its_ends():
    motion = motion_of(swing(), np.array([0.5, 1.5]))
    np.testing.assert_allclose(motion.position, [START, TARGET], atol=1e-15)
    np.testing.assert_allclose(motion.velocity, 0.0, atol=1e-12)


# --- the line ---------------------------------------------------------------------------

angles = st.floats(-3.0, 3.0)


@given(st.floats(-1.5, 1.5), angles)
def test_the_direction_of_a_line_is_the_x_axis_of_yaw_then_pitch(pitch, yaw):
    position = np.array([0.0, 0.0, 0.0, pitch, yaw])
    expected = Rotation.from_euler("ZY", [yaw, pitch]).as_matrix()[:, 0]
    d, w, alpha = line_turn(position, np.zeros(SIZE), np.zeros(SIZE))
    np.testing.assert_allclose(d, expected, atol=1e-14)
    np.testing.assert_array_equal([w, alpha], 0.0)
    assert pitch < 0.0 or expected[2] <= 0.0  # toe down is positive


@given(st.floats(-1.2, 1.2), angles, *[st.floats(-3.0, 3.0)] * 4)
def test_line_turn_is_the_derivative_of_the_orientation(pitch, yaw, dp, dy, ddp, ddy):
    """R(t) of Euler angles that are quadratic in time, differentiated numerically."""
    h = 1e-4
    t = h * np.arange(-2, 3)
    p, y = pitch + dp * t + ddp * t**2 / 2, yaw + dy * t + ddy * t**2 / 2
    R = Rotation.from_euler("ZY", np.column_stack([y, p]))
    turns = (R[1:] * R[:-1].inv()).as_rotvec() / h  # mean angular velocity in W
    w_numeric, alpha_numeric = (turns[1] + turns[2]) / 2, (turns[2] - turns[1]) / h
    rows = np.zeros((3, SIZE))
    rows[:, PITCH], rows[:, YAW] = [pitch, dp, ddp], [yaw, dy, ddy]
    d, w, alpha = line_turn(*rows)
    np.testing.assert_allclose(d, R[2].as_matrix()[:, 0], atol=1e-14)
    np.testing.assert_allclose(w, w_numeric, atol=1e-6)
    np.testing.assert_allclose(alpha, alpha_numeric, atol=1e-5)
