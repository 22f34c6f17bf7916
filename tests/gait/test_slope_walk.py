"""The gait on a plane that is not level: learned, and then in everything that is planned."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from drake_linefoot.gait.footsteps import heading_vector
from drake_linefoot.gait.ground import FELT
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.gait.schedule import contacts, feet_motion
from drake_linefoot.mpc.models.motion import body_motion
from drake_linefoot.statuses import Mode
from tests.helpers.horizons import horizon_at, phases_of
from tests.helpers.pendulum_robot import PendulumRobot
from tests.helpers.phases import mode_of, phase_start, swing_of
from tests.helpers.walking import S, mirror_lines, mirror_places

STEEP = np.tan(np.radians(10.0))
SLOPES = [[STEEP, 0.0], [-STEEP, 0.0], [0.0, STEEP], [-0.08, -0.12]]
COMMAND = [0.4, 0.0, 0.3, 1.0]


def on_plane(slope, points, atol):
    """Every point [x, y, z, ...] lies on the plane through the origin."""
    points = np.asarray(points).reshape(-1, np.shape(points)[-1])
    np.testing.assert_allclose(points[:, 2], points[:, :2] @ slope, atol=atol)


def pitch_on(slope, yaw):
    """Pitch of a line in the plane: square to its normal, toe up is negative."""
    return -np.arctan(slope @ heading_vector(yaw, 1.0, 0.0))


@pytest.fixture(scope="module", params=SLOPES, ids=["up", "down", "left", "askew"])
def walk(request):
    """A slope, and the ticks of a turning walk on it."""
    slope = np.array(request.param)
    robot = PendulumRobot(yaw=0.2, slope=slope)
    return slope, robot.constants, [t.state for t in robot.run(COMMAND, 4.0)]


@pytest.fixture(scope="module")
def known(walk):
    """The states after the slope has been learned."""
    slope, c, states = walk
    return slope, c, [s for s in states if s.clock.time > 3.0][::17]


def feels(s):
    """Whether a foot has just stood alone for as long as it takes to feel the ground."""
    since = s.clock.time - phase_start(s) - GaitParameters().slope_feel_time
    return mode_of(s) == Mode.SWING and abs(since) < 1e-6


def test_the_slope_is_learned_at_touchdowns_and_from_a_foot_that_stands_alone(walk):
    slope, _, states = walk
    errors = [np.linalg.norm(s.ground.slope - slope) for s in states]
    assert errors[0] == np.linalg.norm(slope)
    for a, b in pairwise(states):
        assert b.clock.steps > a.clock.steps or feels(b) or np.all(a.ground.slope == b.ground.slope)
    assert errors[-1] < 2e-4


def test_the_first_foothold_already_is_as_high_as_the_line_of_the_stance_foot_says(walk):
    slope, _, states = walk
    first = next(s for s in states if feels(s))
    stance = first.robot.feet[int(first.clock.side)]
    ahead = heading_vector(stance[3], 1.0, 0.0)
    assert first.clock.steps == 0
    felt = slope @ ahead if abs(slope @ ahead) > FELT else 0.0
    assert first.ground.slope @ ahead == pytest.approx(felt, abs=1e-9)
    up = swing_of(first).target[2] - stance[2]
    assert up == pytest.approx(
        first.ground.slope @ (swing_of(first).target[:2] - stance[:2]), abs=1e-9
    )


def test_a_line_is_not_believed_where_the_last_steps_met_uneven_ground():
    robot = PendulumRobot(slope=SLOPES[0])
    robot.state.ground.unevenness = 2.0 * GaitParameters().unevenness_max
    states = [t.state for t in robot.run(COMMAND, 1.5)]
    assert any(feels(s) for s in states)
    before = [s for s in states if s.clock.steps == 0]
    assert any(feels(s) for s in before)
    assert not any(s.ground.slope.any() for s in before)


def test_nothing_is_learned_where_nothing_shall_be():
    robot = PendulumRobot(GaitParameters(slope_learning=0.0), slope=SLOPES[0])
    ticks = robot.run(COMMAND, 1.5)
    assert ticks[-1].state.clock.steps > 2
    assert all(not t.state.ground.slope.any() for t in ticks)


def test_a_slope_beyond_the_bound_is_not_believed():
    robot = PendulumRobot(GaitParameters(slope_max=0.1), slope=[0.2, -0.2])
    end = robot.run(COMMAND, 2.0)[-1].state
    np.testing.assert_allclose(end.ground.slope, [0.1, -0.1], atol=1e-12)


def test_footholds_lie_on_the_ground_with_its_pitch(known):
    slope, _, states = known
    swinging = [s for s in states if mode_of(s) == Mode.SWING]
    assert len(swinging) > 20
    for s in swinging:
        on_plane(slope, swing_of(s).target, 1e-3)
        assert swing_of(s).target[3] == pytest.approx(
            pitch_on(slope, swing_of(s).target[4]), abs=1e-3
        )


def test_a_foot_is_lifted_from_the_pitch_it_stands_with(walk):
    slope, _, states = walk
    lifted = [s for s in states if mode_of(s) == Mode.SWING and s.clock.time == phase_start(s)]
    for s in [s for s in lifted if s.clock.time > 3.0]:
        yaw = swing_of(s).reference[0, 4]
        assert swing_of(s).reference[0, 3] == pytest.approx(pitch_on(slope, yaw), abs=1e-3)


def test_the_feet_of_the_horizon_lie_on_the_ground(known):
    slope, c, states = known
    for s in states:
        horizon = horizon_at(s, c, 0.6)
        np.testing.assert_array_equal(horizon.slope, s.ground.slope)
        on_plane(slope, horizon.footholds, 1e-3)
        for phase in phases_of(horizon):
            on_plane(slope, phase.feet, 1e-3)
            if phase.swing is not None:
                target = phase.swing.target
                on_plane(slope, target, 1e-3)
                assert target[3] == pytest.approx(pitch_on(slope, target[4]), abs=1e-3)
        times = np.linspace(s.clock.time, s.clock.time + 0.56, 40)
        motion, contact = feet_motion(horizon, times), contacts(horizon, times)
        for side in (0, 1):
            standing = motion.position[side][contact[:, side] == 1.0]
            for line in standing:
                x = Rotation.from_euler("ZY", line[[4, 3]]).as_matrix()[:, 0]
                assert x @ [-slope[0], -slope[1], 1.0] == pytest.approx(0.0, abs=1e-3)


def test_the_com_is_desired_at_one_height_above_the_ground(known):
    slope, c, states = known
    for s in states:
        horizon = horizon_at(s, c, 0.6)
        times = s.clock.time + np.linspace(0.0, 0.56, 30)
        body = body_motion(horizon, s.robot.com, times)
        height = body.r[:, 2] - body.r[:, :2] @ slope
        np.testing.assert_allclose(height, GaitParameters().com_height, atol=2e-3)
        np.testing.assert_allclose(body.v[:, 2], body.v[:, :2] @ slope, atol=1e-3)
        h = 1e-6
        before, after = (body_motion(horizon, s.robot.com, times[1:] + k * h).r for k in (-1, 1))
        np.testing.assert_allclose((after - before) / (2 * h), body.v[1:], atol=1e-5)


@pytest.mark.parametrize("slope", SLOPES)
def test_a_slope_is_climbed_no_faster_than_it_may_be(slope):
    """Either way; and what is learned of the speed there is learned at the speed that is left."""
    p = GaitParameters()
    states = [t.state for t in PendulumRobot(slope=slope).run([1.0, 0.2, 0.0, 1.0], 5.0)]
    speed, steep = np.linalg.norm(states[-1].command.velocity), np.linalg.norm(slope)
    assert speed * steep == pytest.approx(p.climb_max, rel=0.01)
    assert states[-1].command.velocity[0] == pytest.approx(5.0 * states[-1].command.velocity[1])
    assert states[-1].command.clipped > 0
    assert np.all(states[-1].speed.scale != p.speed_scale)


@pytest.mark.parametrize("slope", SLOPES)
def test_a_mirrored_slope_is_walked_as_the_mirror_image(slope):
    flip, command = np.array([1.0, -1.0]), np.array([0.4, 0.1, 0.3, 1.0])
    right = PendulumRobot(GaitParameters(first_swing="right"), 0.2, slope)
    left = PendulumRobot(GaitParameters(first_swing="left"), -0.2, slope * flip)
    mirrored = left.run(command * [1, -1, -1, 1], 1.5)
    for tick, other in zip(right.run(command, 1.5), mirrored, strict=True):
        a, b = tick.state, other.state
        assert (mode_of(a), a.clock.side) == (mode_of(b), 1 - b.clock.side)
        np.testing.assert_allclose(b.ground.slope, a.ground.slope * flip, atol=1e-11)
        np.testing.assert_allclose(b.robot.feet, mirror_places(a.robot.feet)[::-1], atol=1e-9)
        if mode_of(a) == Mode.SWING:
            np.testing.assert_allclose(
                swing_of(b).target, mirror_lines(swing_of(a).target), atol=1e-9
            )
    one, two = (horizon_at(s, r.constants, 0.6) for s, r in ((a, right), (b, left)))
    np.testing.assert_allclose(two.footholds, mirror_places(one.footholds), atol=1e-9)
    times = a.clock.time + np.linspace(0.0, 0.5, 9)
    r, s = (body_motion(h, x.robot.com, times).r for h, x in ((one, a), (two, b)))
    np.testing.assert_allclose(s, r @ S, atol=1e-9)
