"""Footholds: the walk that comes of them, their limits, and their mirror image."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from drake_linefoot.gait.footsteps import (
    StepCommand,
    clip_foothold,
    heading_vector,
    next_foothold,
    nominal_strides,
    step_command,
)
from drake_linefoot.gait.state import YAW
from tests.helpers.phases import swing_of
from tests.helpers.steps import (
    LENGTH_MAX,
    OFFSET,
    OMEGA,
    ONE,
    SCALE,
    SHAPE,
    SLOPE,
    UNLIMITED,
    WIDTH,
    WIDTH_MAX,
    WIDTH_MIN,
    ZERO,
    T,
    aimed,
    angles,
    commands,
    constants,
    points,
    sides,
    swing_state,
)

# The offset counts six strides: what is left out is exp(-6 w T) = 0.5 % of it.
SERIES = 0.007


def walk(command, steps=60, yaw=0.3, shape=UNLIMITED, start=(0.0, -0.2)):
    """A pendulum that steps where `next_foothold` says, integrated numerically.

    Returns footholds, CoM at each switch and headings, one row for each step.
    """
    stance, side = np.array([0.0, 0.5 * WIDTH]), 0
    state = np.array([0.0, 0.0, *start])  # CoM and its velocity; far from a steady walk
    feet, com, headings = [stance], [state[:2]], [yaw]
    for _ in range(steps):

        def fall(t, y, p=stance):
            return [*y[2:], *OMEGA**2 * (y[:2] - p)]

        state = solve_ivp(fall, (0.0, T), state, rtol=1e-9, atol=1e-11).y[:, -1]
        yaw, side = yaw + command.turn_rate * T, 1 - side
        xi = state[:2] + state[2:] / OMEGA
        stance, moved = next_foothold(xi, stance, yaw, side, command, shape)
        assert not moved or shape is SHAPE
        feet.append(stance)
        com.append(state[:2])
        headings.append(yaw)
    return np.array(feet), np.array(com), np.array(headings)


def middles(feet):
    return 0.5 * (feet[1:] + feet[:-1])


def in_heading(vectors, yaw):
    return np.array([heading_vector(-h, *v) for v, h in zip(vectors, yaw, strict=True)])


@pytest.mark.parametrize("velocity", [[0.0, 0.0], [0.8, 0.0], [-0.6, 0.0], [0.0, 0.4], [0.5, -0.3]])
def test_straight_walks_go_at_the_commanded_velocity(velocity):
    feet, com, headings = walk(StepCommand(np.array(velocity), 0.0, T))
    for path in (feet, com):
        mean = (path[-1] - path[-21]) / (20 * T)
        measured = heading_vector(-headings[-1], *mean)
        np.testing.assert_allclose(measured, velocity, atol=SERIES * (0.1 + np.abs(velocity).max()))
    across = in_heading(np.diff(feet[-20:], axis=0), headings[-19:])[:, 1] - T * velocity[1]
    np.testing.assert_allclose(np.abs(across), WIDTH, rtol=0.01)
    assert np.all(across[1:] * across[:-1] < 0.0)  # left, right, left ...


@pytest.mark.parametrize(
    ("velocity", "turn_rate"),
    [([0.0, 0.0], 1.5), ([0.6, 0.0], 0.6), ([0.4, 0.2], -1.0), ([-0.5, 0.0], 0.8)],
)
def test_turning_walks_follow_an_arc(velocity, turn_rate):
    """The feet's middle runs on a circle of radius |v| / w at the speed |v|."""
    feet, _, _ = walk(StepCommand(np.array(velocity), turn_rate, T), steps=80)
    path = middles(feet)[30:]
    radius = np.linalg.norm(velocity) / abs(turn_rate)
    # Footholds turn about one point: fit the circle by least squares.
    rows = np.column_stack([2 * path, np.ones(len(path))])
    cx, cy, c = np.linalg.lstsq(rows, (path**2).sum(axis=1), rcond=None)[0]
    fitted = np.sqrt(c + cx**2 + cy**2)
    # Feet that are wT apart in heading have their middle W / 2 sin(wT / 2) along the path.
    along = 0.5 * WIDTH * np.sin(0.5 * turn_rate * T)
    np.testing.assert_allclose(fitted, np.hypot(radius, along), rtol=0.015)
    angle = np.unwrap(np.arctan2(path[:, 1] - cy, path[:, 0] - cx))
    if radius > 0.0:
        assert (angle[-1] - angle[0]) / (T * (len(path) - 1)) == pytest.approx(turn_rate, rel=0.01)


def test_the_com_leans_into_a_turn_by_what_the_pendulum_needs():
    """For a CoP on a circle c'' = W^2 (c - p) has c = p W^2 / (W^2 + w^2): a smaller circle."""
    speed, w = 0.6, 1.0
    feet, com, _ = walk(StepCommand(np.array([speed, 0.0]), w, T), steps=90)
    path, c = middles(feet)[40:], middles(com)[40:]
    centre = path[: int(2 * np.pi / w / T)].mean(axis=0)
    ratio = np.linalg.norm(c - centre, axis=1).mean() / np.linalg.norm(path - centre, axis=1).mean()
    assert ratio == pytest.approx(OMEGA**2 / (OMEGA**2 + w**2), abs=0.01)


@given(commands, angles, sides)
def test_strides_take_the_path_and_keep_the_feet_a_width_apart(command, yaw, side):
    """Two strides later the same foot has moved along the arc of the path by 2 T."""
    strides = nominal_strides(command, constants(UNLIMITED, strides_ahead=2), yaw, side)
    # The path itself, integrated: from where the foot stands beside it.
    aside = (1.0, -1.0)[side] * 0.5 * WIDTH

    def rate(t, y):
        return heading_vector(yaw + command.turn_rate * t, *command.velocity)

    path = solve_ivp(rate, (0.0, 2 * T), np.zeros(2), rtol=1e-10, atol=1e-12).y[:, -1]
    end = yaw + 2 * T * command.turn_rate
    expected = path + heading_vector(end, 0.0, aside) - heading_vector(yaw, 0.0, aside)
    np.testing.assert_allclose(strides.sum(axis=0), expected, atol=1e-9)


@given(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5), angles, sides)
def test_a_steady_sideways_walk_never_crosses_its_feet(forward, left, yaw, side):
    """Every stride is within the limit, with feet wider apart than standing when need be."""
    command = StepCommand(np.array([forward, left]), 0.0, T)
    strides = nominal_strides(command, SHAPE, yaw, side)
    outward = in_heading(strides, [yaw] * len(strides))[:, 1] * np.resize([-1, 1], len(strides))
    assert (outward * (1.0, -1.0)[side]).min() >= WIDTH_MIN - 1e-12
    if abs(left) * T < WIDTH - WIDTH_MIN:
        apart = outward[:2].sum() * (0.5, -0.5)[side]
        assert apart == pytest.approx(WIDTH, abs=1e-12)


@pytest.mark.parametrize("left", [0.3, -0.5])
def test_a_sideways_walk_settles_within_the_limits(left):
    """Also where a stride as wide as standing would cross the feet every other step."""
    _, com, _ = walk(StepCommand(np.array([0.0, left]), 0.0, T), shape=SHAPE, start=(0.0, 0.1))
    speed = (com[-1] - com[-21]) / (20 * T)
    np.testing.assert_allclose(heading_vector(-0.3, *speed), [0.0, left], atol=0.02)


@given(points, points, angles, sides)
def test_clipping_holds_the_limits(foothold, stance, yaw, side):
    place, moved = clip_foothold(foothold, stance, yaw, side, SHAPE.step_limits)
    forward, left = heading_vector(-yaw, *(place - stance))
    outward = left if side == 0 else -left
    assert abs(forward) <= LENGTH_MAX + 1e-12
    assert WIDTH_MIN - 1e-12 <= outward <= WIDTH_MAX + 1e-12
    assert moved == bool(np.any(place != foothold))
    again, _ = clip_foothold(place, stance, yaw, side, SHAPE.step_limits)
    np.testing.assert_allclose(again, place, atol=1e-14)


@given(st.floats(-0.499, 0.499), st.floats(0.101, 0.449), points, angles, sides)
def test_a_foothold_within_the_limits_is_not_touched(forward, outward, stance, yaw, side):
    left = outward if side == 0 else -outward
    foothold = stance + heading_vector(yaw, forward, left)
    place, moved = clip_foothold(foothold, stance, yaw, side, SHAPE.step_limits)
    assert not moved
    np.testing.assert_array_equal(place, foothold)


@given(points, points, angles, sides, st.floats(-0.5, 0.5), st.floats(0.1, 0.45))
def test_clipping_moves_to_the_nearest_place(foothold, stance, yaw, side, forward, outward):
    """No other place within the limits is nearer."""
    place, _ = clip_foothold(foothold, stance, yaw, side, SHAPE.step_limits)
    other = stance + heading_vector(yaw, forward, outward if side == 0 else -outward)
    assert np.linalg.norm(place - foothold) <= np.linalg.norm(other - foothold) + 1e-12


@given(points, points, st.floats(-3.0, 3.0), sides, commands)
def test_mirrored_input_gives_the_mirrored_foothold(xi, stance, yaw, side, command):
    flip = np.array([1.0, -1.0])
    place, moved = next_foothold(xi, stance, yaw, side, command, SHAPE)
    mirrored = StepCommand(command.velocity * flip, -command.turn_rate, T)
    other, other_moved = next_foothold(xi * flip, stance * flip, -yaw, 1 - side, mirrored, SHAPE)
    np.testing.assert_allclose(other, place * flip, atol=1e-12)
    assume(np.abs(place - xi).max() > 1e-9)
    assert other_moved == moved


@given(points, points, angles, sides, commands, points, angles)
def test_nothing_depends_on_where_the_world_begins(xi, stance, yaw, side, command, shift, turn):
    def move(p):
        return shift + heading_vector(turn, *p)

    place, _ = next_foothold(xi, stance, yaw, side, command, SHAPE)
    other, _ = next_foothold(move(xi), move(stance), yaw + turn, side, command, SHAPE)
    np.testing.assert_allclose(other, move(place), atol=1e-12)


# --- the target of the swing foot -------------------------------------------------------


def slow_target(com, velocity, stance, yaw, side, command, until_switch, shape):
    """The foothold from a numerically integrated DCM and sixty strides, left out of the limits."""
    fall = solve_ivp(
        lambda t, y: [*y[2:], *OMEGA**2 * (y[:2] - stance)],
        (0.0, until_switch), [*com, *velocity], rtol=1e-11, atol=1e-12,
    ).y[:, -1]  # fmt: skip
    strides = nominal_strides(command, constants(shape, strides_ahead=60), yaw, side)
    ahead = np.exp(-OMEGA * T * np.arange(1, 61)) @ strides
    return fall[:2] + fall[2:] / OMEGA - ahead


def test_what_was_learned_scales_and_shifts_the_command():
    case = (ZERO, ZERO, ZERO, 0.0, 0, StepCommand(np.array([0.5, -0.1]), 0.4, T))
    command = step_command(swing_state(case), SHAPE)
    np.testing.assert_allclose(command.velocity, [0.57, -0.18], atol=1e-15)
    assert command.turn_rate == 0.4


@given(points, points, points, st.floats(-0.5, 0.5), sides, commands, st.floats(0.06, 0.2))
def test_the_target_is_where_a_falling_pendulum_needs_it(
    com, velocity, stance, yaw, side, command, remaining
):
    case = (com, velocity, stance, yaw, side, command)
    state = swing_state(case, height=0.03, scale=ONE, offset=ZERO)
    swing_of(state).reference[0, YAW] = yaw + 2.0 * np.pi
    target, moved = aimed(state, remaining, UNLIMITED)
    heading = yaw + command.turn_rate * (remaining + 0.5 * T)
    expected = slow_target(
        com, velocity, stance, heading, side, command, remaining + SHAPE.switch, UNLIMITED
    )
    reach = np.abs(heading_vector(-heading, *(expected - stance))).max()
    assume(reach < 8.9)
    assert not moved
    np.testing.assert_allclose(target[:2], expected, atol=SERIES * 2.0)
    # Height and pitch of the plane through the stance foot; a line with the toe up is negative.
    assert target[2] == pytest.approx(0.03 + SLOPE @ (target[:2] - stance), abs=1e-12)
    along = heading_vector(heading, 1.0, 0.0)
    assert np.tan(target[3]) == pytest.approx(-SLOPE @ along, abs=1e-12)
    assert target[4] == pytest.approx(heading + 2.0 * np.pi, abs=1e-12)  # the short way


@given(points, points, points, st.floats(-3.0, 3.0), sides, commands)
def test_mirrored_input_gives_the_mirrored_target(com, velocity, stance, yaw, side, command):
    flip, line = np.array([1.0, -1.0]), np.array([1.0, -1.0, 1.0, 1.0, -1.0])
    state = swing_state((com, velocity, stance, yaw, side, command))
    target, moved = aimed(state, 0.1, SHAPE)
    mirrored = StepCommand(command.velocity * flip, -command.turn_rate, T)
    case = (com * flip, velocity * flip, stance * flip, -yaw, 1 - side, mirrored)
    image = swing_state(case, slope=SLOPE * flip, scale=SCALE, offset=OFFSET * flip)
    other, other_moved = aimed(image, 0.1, SHAPE)
    np.testing.assert_allclose(other, target * line, atol=1e-12)
    assert other_moved == moved
