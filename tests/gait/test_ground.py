"""The ground as a plane: its height and pitch, and how feet that stand on it tell its slope."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from drake_linefoot.gait.ground import (
    FELT,
    height_of_swing,
    pressed_point,
    update_ground_estimate_in_run,
    update_slope_estimate_by_feet,
    update_slope_estimate_by_line,
    update_unevenness_estimate,
)
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.gait.patches import height_on, line_pitch
from drake_linefoot.statuses import Mode
from tests.helpers.pendulum_robot import PendulumRobot
from tests.helpers.phases import mode_of

angles = st.floats(-7.0, 7.0)
rises = st.floats(-0.25, 0.25)
slopes = st.tuples(rises, rises).map(np.array)
points = st.tuples(*[st.floats(-3.0, 3.0)] * 2).map(np.array)
sides = st.sampled_from([0, 1])
BOUND = 0.3
APART = 0.05  # [m]


def stand(slope, places, yaws):
    """Feet that lie on a plane through the origin, shape (2, 4), and the rise of their lines."""
    feet = np.column_stack([places, np.asarray(places) @ slope, yaws])
    return feet, slope[0] * np.cos(yaws) + slope[1] * np.sin(yaws)


def by_feet(slope, feet, side, line_slope, share, bound, apart, cross_slope=np.nan):
    """The slope after feet with lines, or with a sole whose rise to the left is given."""
    lies, line = np.array([line_slope, cross_slope]), np.isnan(cross_slope)
    lies[1] = 0.0 if line else cross_slope
    shares = share, 0.0 if line else share
    return update_slope_estimate_by_feet(slope, feet, side, lies, shares, bound, apart)


def walk_on(slope, heading, steps, share, believed=(0.0, 0.0)):
    """What is believed after some steps of 0.1 m with feet 0.16 m apart."""
    along = np.array([np.cos(heading), np.sin(heading)])
    left = np.array([-along[1], along[0]])
    out = np.array(believed, dtype=float)
    for k in range(steps):
        stance = k % 2
        place = [0.1 * (k + (side != stance)) * along for side in (0, 1)]
        feet, line_slope = stand(
            slope, [place[0] + 0.08 * left, place[1] - 0.08 * left], [heading] * 2
        )
        out = by_feet(out, feet, stance, line_slope[stance], share, BOUND, APART)
    return out


@given(slopes, points, points)
def test_height_is_that_of_the_plane(slope, a, b):
    """The way between two points of the plane is square to its normal."""
    known = np.array([*a, 0.37])
    way = np.array([*(b - a), height_on(slope, known, b) - 0.37])
    assert way @ [-slope[0], -slope[1], 1.0] == pytest.approx(0.0, abs=1e-14)


@given(slopes, angles)
def test_a_line_of_that_pitch_lies_on_the_plane(slope, yaw):
    line = Rotation.from_euler("ZY", [yaw, line_pitch(slope, yaw)]).as_matrix()[:, 0]
    assert line @ [-slope[0], -slope[1], 1.0] == pytest.approx(0.0, abs=1e-14)
    line_slope = slope[0] * np.cos(yaw) + slope[1] * np.sin(yaw)  # per metre
    assert line[2] / np.hypot(*line[:2]) == pytest.approx(line_slope, abs=1e-14)
    assert np.sign(line_pitch(slope, yaw)) == -np.sign(line_slope)


def test_level_ground_has_neither():
    level = np.zeros(2)
    assert line_pitch(level, 0.7) == 0.0
    assert height_on(level, np.array([1.0, 2.0, 0.3]), np.array([5.0, 6.0])) == 0.3


@pytest.mark.parametrize("share", [0.5, 1.0, 3.0])
@pytest.mark.parametrize("heading", [0.0, 1.0, np.pi / 2, 2.5, -2.0])
@pytest.mark.parametrize("slope", [[0.18, 0.0], [-0.1, 0.15], [0.0, -0.2]])
def test_steps_on_a_plane_teach_its_slope(slope, heading, share):
    """Up, down and along it; the error of the belief falls with every step."""
    errors = [
        np.linalg.norm(walk_on(np.array(slope), heading, n, share) - slope)
        for n in (0, 1, 2, 4, 8, 16, 60)
    ]
    assert np.all(np.diff(errors) <= 1e-15)
    assert errors[1] < 0.85 * errors[0]
    assert errors[-1] < 1e-5


@given(slopes, angles, angles, points, points, sides, st.floats(0.0, 10.0))
def test_what_is_true_already_stays(slope, yaw, other, a, b, side, share):
    feet, line_slope = stand(slope, [a, b], np.array([yaw, other]))
    new = by_feet(slope, feet, side, line_slope[side], share, BOUND, APART)
    np.testing.assert_allclose(new, slope, atol=1e-13)


@given(
    slopes, points, points, angles, rises, st.floats(-0.1, 0.1), sides, st.floats(0.01, 10.0),
    rises | st.just(np.nan),
)  # fmt: skip
def test_it_is_the_least_squares_of_what_is_said(
    before, a, b, yaw, line_slope, up, side, share, cross_slope
):
    """Three sayings of lines; of a sole a fourth, of its roll."""
    feet = np.array([[*a, 0.2, yaw], [*b, 0.2 + up, yaw]])
    rows, said, weight = [np.eye(2)], [before], [1.0, 1.0, share]
    rows.append([[np.cos(yaw), np.sin(yaw)]])
    said.append([line_slope])
    if np.isfinite(cross_slope):
        rows.append([[-np.sin(yaw), np.cos(yaw)]])
        said.append([cross_slope])
        weight.append(share)
    way = feet[1 - side] - feet[side]
    apart = np.hypot(*way[:2])
    if apart > 0.05:
        rows.append([way[:2] / apart])
        said.append([way[2] / apart])
        weight.append(share)
    root = np.sqrt(weight)
    best = np.linalg.lstsq(root[:, None] * np.vstack(rows), root * np.hstack(said), rcond=None)[0]
    new = by_feet(before, feet, side, line_slope, share, 100.0, APART, cross_slope)
    np.testing.assert_allclose(new, best, atol=1e-9)
    bounded = by_feet(before, feet, side, line_slope, share, 0.1, APART, cross_slope)
    np.testing.assert_allclose(bounded, np.clip(best, -0.1, 0.1), atol=1e-9)


@pytest.mark.parametrize("apart", [0.0, 1e-12, 0.049])
def test_feet_close_to_each_other_say_nothing_of_the_ground_between(apart):
    """A step in the ground between them would be a wall; only the line counts."""
    feet = np.array([[0.0, 0.0, 0.0, 0.0], [0.0, apart, 0.04, 0.0]])
    new = by_feet(np.array([0.0, 0.05]), feet, 0, 0.1, 1.0, BOUND, APART)
    np.testing.assert_allclose(new, [0.05, 0.05], atol=1e-15)


def test_feet_one_behind_the_other_leave_what_they_do_not_see():
    feet, line_slope = stand(np.array([0.1, 0.2]), [[0.0, 0.0], [0.3, 0.0]], np.zeros(2))
    new = by_feet(np.array([0.0, -0.03]), feet, 0, line_slope[0], 1.0, BOUND, APART)
    np.testing.assert_allclose(new, [0.1 * 2 / 3, -0.03], atol=1e-15)


@given(slopes, points, points, angles, angles, rises, sides)
def test_mirrored_feet_teach_the_mirrored_slope(before, a, b, yaw, other, line_slope, side):
    feet = np.array([[*a, 0.01, yaw], [*b, -0.02, other]])
    flip = np.array([1.0, -1.0])
    mirrored = (feet * [1.0, -1.0, 1.0, -1.0])[::-1].copy()
    new = by_feet(before, feet, side, line_slope, 1.0, BOUND, APART)
    image = by_feet(before * flip, mirrored, 1 - side, line_slope, 1.0, BOUND, APART)
    np.testing.assert_allclose(image, new * flip, atol=1e-14)


def test_a_share_of_zero_learns_nothing():
    feet, line_slope = stand(np.array([0.1, 0.2]), [[0.0, 0.1], [0.1, -0.1]], np.zeros(2))
    new = by_feet(np.array([0.02, -0.01]), feet, 0, line_slope[0], 0.0, BOUND, APART)
    np.testing.assert_array_equal(new, [0.02, -0.01])


@given(slopes, angles, rises, st.floats(0.0, 3.0))
def test_a_line_says_how_the_ground_rises_along_it_and_nothing_of_across(
    before, yaw, line_slope, share
):
    along, across = np.array([np.cos(yaw), np.sin(yaw)]), np.array([-np.sin(yaw), np.cos(yaw)])
    new = update_slope_estimate_by_line(before, yaw, line_slope, share, 100.0)
    believed = min(share, 1.0) if abs(line_slope - along @ before) > FELT else 0.0
    expected = believed * line_slope + (1.0 - believed) * (along @ before)
    assert along @ new == pytest.approx(expected, abs=1e-13)
    assert across @ new == pytest.approx(across @ before, abs=1e-13)
    bounded = update_slope_estimate_by_line(before, yaw, line_slope, share, 0.1)
    np.testing.assert_allclose(bounded, np.clip(new, -0.1, 0.1), atol=1e-15)


def test_a_line_on_level_ground_changes_nothing_when_its_ends_sink_in_a_little():
    level = np.zeros(2)
    np.testing.assert_array_equal(
        update_slope_estimate_by_line(level, 0.3, 0.019, 1.0, BOUND), level
    )
    assert update_slope_estimate_by_line(level, 0.0, 0.021, 1.0, BOUND)[0] == 0.021


@given(slopes, angles, rises)
def test_a_mirrored_line_says_the_mirrored_slope(before, yaw, line_slope):
    flip = np.array([1.0, -1.0])
    image = update_slope_estimate_by_line(before * flip, -yaw, line_slope, 1.0, BOUND)
    np.testing.assert_allclose(
        image, update_slope_estimate_by_line(before, yaw, line_slope, 1.0, BOUND) * flip, atol=1e-14
    )


def test_steps_that_meet_the_plane_make_it_even_and_others_do_not():
    slope, stance = np.array([0.1, -0.2]), np.array([1.0, 2.0, 0.5, 0.3])
    on_plane = np.array([1.2, 1.9, 0.5 + 0.02 + 0.02])
    largest = GaitParameters().unevenness_max
    up, down = (
        update_unevenness_estimate(
            0.0, height_on(slope, stance, on_plane), on_plane + np.array([0.0, 0.0, miss])
        )
        for miss in (0.04, -0.04)
    )
    assert up == pytest.approx(down)
    assert up < largest  # so far one step is missed where a slope begins
    twice = update_unevenness_estimate(
        up, height_on(slope, stance, on_plane), on_plane + np.array([0.0, 0.0, 0.03])
    )
    assert twice > largest
    left = [twice]
    for _ in range(10):
        left.append(
            update_unevenness_estimate(left[-1], height_on(slope, stance, on_plane), on_plane)
        )
    assert np.all(np.diff(left) < 0.0)
    assert left[-1] < 0.25 * twice


@given(slopes, angles, st.floats(-0.5, 0.5), st.floats(-1.0, 1.0), st.floats(-0.06, 0.06))
def test_a_line_that_lands_tilted_meets_the_ground_where_it_is_pressed(
    slope, yaw, pitch, place, along
):
    """On even ground a foot may land on heel or toe: that does not make it uneven."""
    line = Rotation.from_euler("ZY", [yaw, pitch]).as_matrix()[:, 0]
    stance = np.array([0.0, 0.0, 0.2, yaw])
    touches = np.array([place, -0.3, 0.0])
    touches[2] = height_on(slope, stance, touches)
    foot = np.array([*(touches - along * line), yaw])
    found = pressed_point(foot, line[2] / np.hypot(*line[:2]), along)
    np.testing.assert_allclose(found, touches, atol=1e-12)
    assert update_unevenness_estimate(0.0, height_on(slope, stance, found), found) == pytest.approx(
        0.0, abs=1e-12
    )


@given(st.floats(0.0, 0.05), st.floats(1.0, 3.0))
def test_rougher_ground_is_never_stepped_over_more_flatly(unevenness, more):
    p, c = GaitParameters(), PendulumRobot().constants
    height = height_of_swing(unevenness, c)
    assert p.swing_height <= height <= height_of_swing(more * unevenness, c)
    if unevenness >= 1.6 * p.unevenness_max:
        assert height == pytest.approx(p.swing_height_uneven)
    if unevenness <= p.unevenness_max:
        assert height == p.swing_height


def test_a_swing_that_is_to_be_high_everywhere_is_not_lower_on_uneven_ground():
    c = PendulumRobot(GaitParameters(swing_height=0.12)).constants
    assert height_of_swing(1.0, c) == 0.12


@pytest.mark.parametrize("unevenness", [0.0, 0.012, 0.02])
def test_the_foot_is_lifted_as_high_as_the_last_steps_ask_for(unevenness):
    robot = PendulumRobot()
    robot.run([0.0, 0.0, 0.0, 1.0], 0.5)
    robot.state.ground.unevenness = unevenness
    ticks = robot.run([0.0, 0.0, 0.0, 1.0], 1.2)
    heights = {}
    for tick in ticks:
        if mode_of(tick.state) == Mode.SWING:
            step = int(tick.state.clock.steps)
            heights.setdefault(step, []).append(tick.foot.position[0, 2])
    _, *whole, _ = heights
    asked = {int(t.state.clock.steps): t.state.ground.unevenness for t in ticks}
    assert len(whole) > 2
    for step in whole:
        expected = height_of_swing(asked[step], robot.constants)
        assert max(heights[step]) == pytest.approx(expected, abs=1e-4)


def test_a_run_believes_the_less_in_slopes_the_more_uneven_it_is():
    """Tiles that are as likely up as down by 3 cm have no slope, whatever two feet on them say."""

    def size_of_slopes(flight):
        robot, random, slopes = PendulumRobot(), np.random.default_rng(0), []
        s = robot.state
        s.command.flight, s.clock.side = flight, 0
        for _ in range(400):
            here, there = random.uniform(-0.03, 0.03, 2)
            s.robot.feet[:] = [[0.25, 0.06, here, 0.0], [0.25, -0.06, 0.3, 0.0]]
            s.swing.lifted[1] = [0.0, -0.06, there]
            update_ground_estimate_in_run(s, robot.measure(), robot.constants)
            slopes.append(s.ground.slope.copy())
        return np.sqrt(np.mean(np.square(slopes[50:])))

    assert size_of_slopes(0.06) < 0.6 * size_of_slopes(0.0)


@pytest.mark.parametrize("slope", [(0.1, 0.0), (-0.08, 0.03)])
def test_a_run_learns_the_slope_from_where_the_feet_have_stood(slope):
    """The other foot is in the air already; a line that lies askew on an edge is half believed."""
    for side in (0, 1):
        robot = PendulumRobot(slope=slope)
        s, places = robot.state, np.array([[0.0, 0.06], [0.25, -0.06]])
        s.clock.side = side
        for k in range(8):
            here, there = places[k % 2] + [0.25 * k, 0.0], places[1 - k % 2] + [0.25 * k - 0.25, 0]
            s.robot.feet[side] = [*here, here @ robot.slope, 0.0]
            s.robot.feet[1 - side] = [*here, 0.3, 0.0]
            s.swing.lifted[1 - side] = [*there, there @ robot.slope]
            update_ground_estimate_in_run(s, robot.measure(), robot.constants)
        np.testing.assert_allclose(s.ground.slope, slope, atol=0.02)
        assert s.ground.unevenness < robot.constants.unevenness_max
        s.robot.feet[side, 2] += 0.1
        update_ground_estimate_in_run(s, robot.measure(), robot.constants)
        assert s.ground.unevenness > robot.constants.unevenness_max
