"""What a standing foot tells of its hold: which ends bear its load and grip, slip and friction."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_linefoot.contact.wrench_cone import ground_frame
from drake_linefoot.gait.footing import (
    forces_on_ground,
    has_full_friction,
    is_at_stop,
    present_load_shares,
    regain_friction,
    update_friction_estimate,
    update_friction_share_estimate,
    update_load_share_estimate,
)
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.robot.dynamics import contact_frame
from drake_linefoot.statuses import Mode
from tests.helpers.pendulum_robot import DT, HALF_LENGTH, PendulumRobot
from tests.helpers.phases import mode_of, phase_start

C, X = PendulumRobot().constants, HALF_LENGTH
COMMAND = [0.3, 0.0, 0.0, 1.0]
HEEL, TOE = 0, 1
FAST = GaitParameters().contact_speed  # [m/s] of the ends of a foot that turns
TILES = 1.0  # [m] of unevenness, which a few steps on a floor do not forget
rises, angles = st.floats(-0.25, 0.25), st.floats(-7.0, 7.0)
slopes = st.tuples(rises, rises).map(np.array)


def pressed(end, load=200.0):
    """The wrench on each foot whose load is on one end, shape (2, 5)."""
    return np.tile([0.0, 0.0, load, (X if end == HEEL else -X) * load, 0.0], (2, 1))


@given(slopes, angles, st.integers(0, 2**32 - 1))
def test_forces_at_the_ends_are_found_in_the_wrench_that_they_make(slope, heading, seed):
    """To the side and along the normal; ahead they only have their sum."""
    n = np.array([-slope[0], -slope[1], 1.0]) / np.sqrt(1.0 + slope @ slope)
    along = np.array([np.cos(heading), np.sin(heading)])
    x = np.array([*along, along @ slope]) / np.hypot(1.0, along @ slope)
    axes = np.array([x, np.cross(n, x), n])
    heel, toe = np.random.default_rng(seed).uniform([-50, -50, 10], [50, 50, 200], (2, 3)) @ axes
    R_WC = contact_frame(np.column_stack([x, x, x]))
    moment = X * np.cross(x, toe - heel)
    wrench = np.concatenate([heel + toe, R_WC[:, 1:].T @ moment])
    found = forces_on_ground(wrench, R_WC, ground_frame(R_WC, slope), C)
    for force, at in ((heel, found[HEEL]), (toe, found[TOE])):
        np.testing.assert_allclose(at[1:], axes[1:] @ force, atol=1e-9)
    np.testing.assert_allclose(found.sum(axis=0), axes @ (heel + toe), atol=1e-9)


@pytest.mark.parametrize("period", [0.0005, 0.001, 0.002])
@pytest.mark.parametrize("at_toe", [0.0, 0.3, 1.0])
def test_what_an_end_bears_is_known_after_some_hundredths_of_a_second(at_toe, period):
    forces, shares = 150.0 * np.array([[0, 0, 1.0 - at_toe], [0, 0, at_toe]]), np.full(2, 0.5)
    known = []
    for _ in range(round(0.1 / period)):
        shares = update_load_share_estimate(shares, present_load_shares(shares, forces), period)
        known.append(shares)
    known, target = np.array(known), np.array([1.0 - at_toe, at_toe])
    np.testing.assert_allclose(known.sum(axis=1), 1.0)
    np.testing.assert_allclose(known[-1], target, atol=2e-3)
    soon = known[round(0.008 / period) - 1]
    np.testing.assert_allclose(soon - target, (0.5 - target) * np.exp(-1.0), atol=0.06)


def test_a_foot_that_is_pulled_bears_nothing_and_tells_nothing():
    before = np.array([0.3, 0.7])
    for load in (0.0, -50.0):
        forces = np.array([[1.0, 2.0, 0.5 * load], [3.0, 4.0, 0.5 * load]])
        np.testing.assert_array_equal(present_load_shares(before, forces), before)
    outside = present_load_shares(before, np.array([[0, 0, -20.0], [0, 0, 120.0]]))
    np.testing.assert_array_equal(outside, [0.0, 1.0])


@pytest.mark.parametrize(
    ("share", "turns", "at_first", "then"),
    [
        (0.0, False, True, False),  # rolls over an end
        (0.0, True, False, False),
        (0.04, False, True, False),
        (0.055, True, True, False),
        (0.065, True, True, True),
        (0.11, False, True, True),  # a heel that bears little, but bears
    ],
)
@pytest.mark.parametrize("end", [HEEL, TOE])
def test_an_end_hangs_from_when_the_foot_turns_about_the_other_until_it_bears(
    end, share, turns, at_first, then
):
    shares = np.full(2, 1.0 - share)
    shares[end] = share
    held, hung = np.ones(2), np.ones(2)
    hung[end] = update_friction_share_estimate(held, np.zeros(2), np.zeros(2), True)[end]
    assert 0.0 < hung[end] <= 0.1
    for before, grips in ((held, at_first), (hung, then)):
        after = update_friction_share_estimate(before, shares, shares, turns)
        assert after[1 - end] == 1.0
        assert after[end] == (1.0 if grips else hung[end])
        assert has_full_friction(after) == grips


def walked(wrench, turning, slope=(0.15, 0.0), unevenness=0.0):
    """A walk on ground whose slope is not known; a stance foot turns at its ends' speed [m/s]."""
    robot = PendulumRobot(slope=slope)
    robot.state.ground.unevenness = unevenness
    robot.wrench, still = wrench, robot.dynamics
    robot.dynamics = lambda: still()._replace(w_WF=np.tile([0.0, 0.0, turning / X], (2, 1)))
    return [t.state for t in robot.run(COMMAND, 1.2)]


@pytest.mark.parametrize("unevenness", [0.0, TILES])
@pytest.mark.parametrize("end", [HEEL, TOE])
def test_a_foot_that_turns_about_an_end_grips_with_that_and_tells_no_slope_of_tiles(
    end, unevenness
):
    """Beyond the edge of a tile an end hangs in the air; where a slope begins it tells of that."""
    states = walked(pressed(end), 1.01 * FAST, unevenness=unevenness)
    assert states[-1].clock.steps >= 2
    if unevenness:
        assert not any(s.ground.slope.any() for s in states)
    else:
        assert states[-1].ground.slope[0] == pytest.approx(0.15, abs=1e-3)
    for s in states:
        since, side = s.clock.time - phase_start(s), int(s.clock.side)
        assert np.all(
            s.footing.friction_shares[1 - side] == 1.0
        )  # what is to stand next is not known yet
        assert s.footing.friction_shares[side, end] == 1.0
        if mode_of(s) == Mode.SWING and since > 0.05:
            assert s.footing.friction_shares[side, 1 - end] <= 0.1
        if mode_of(s) == Mode.DOUBLE and since < 0.5 * DT:  # just landed
            assert np.all(s.footing.friction_shares == 1.0)


@pytest.mark.parametrize("turning", [0.0, 1.01])
def test_a_foot_that_bears_on_both_ends_grips_with_both_and_tells_the_slope(turning):
    even = pressed(HEEL)
    even[:, 3] = 0.0
    states = walked(even, turning * FAST)
    assert all(np.all(s.footing.friction_shares == 1.0) for s in states)
    assert states[-1].ground.slope[0] == pytest.approx(0.15, abs=1e-3)


@pytest.mark.parametrize("slope", [0.0, 0.15])
@pytest.mark.parametrize("end", [HEEL, TOE])
def test_a_foot_that_does_not_turn_may_roll_over_an_end(end, slope):
    assert all(
        np.all(s.footing.friction_shares == 1.0)
        for s in walked(pressed(end), 0.99 * FAST, (slope, 0.0))
    )


@pytest.mark.parametrize("turning", [-1.0, 1.0])
@pytest.mark.parametrize("end", [HEEL, TOE])
def test_a_foot_that_turns_about_an_end_grips_with_that_until_the_other_bears(end, turning):
    """Also when it does not turn any more."""
    robot = PendulumRobot()
    robot.wrench = pressed(end)
    while not (
        mode_of(robot.state) == Mode.SWING
        and robot.state.clock.time > phase_start(robot.state) + 0.06
    ):
        robot.tick(COMMAND)
    side = int(robot.state.clock.side)
    assert np.all(robot.state.footing.friction_shares == 1.0)
    turn, fast = robot.dynamics, turning * 1.01 * FAST / X
    robot.dynamics = lambda: turn()._replace(w_WF=np.tile([0.0, 0.0, fast], (2, 1)))
    robot.tick(COMMAND)
    robot.dynamics = turn
    for _ in range(10):
        robot.tick(COMMAND)
        assert robot.state.footing.friction_shares[side, 1 - end] <= 0.1
        assert robot.state.footing.friction_shares[side, end] == 1.0
    robot.wrench[:, 3] = 0.0
    for _ in range(20):
        robot.tick(COMMAND)
    assert mode_of(robot.state) == Mode.SWING
    assert np.all(robot.state.footing.friction_shares == 1.0)


def slide(slope, heading, mu, ends, speed=0.3, normal=100.0):
    """A foot on a slope that some of its ends slide on, aside; Coulomb's friction is on them.

    Returns:
        Velocity of its middle and angular velocity, its wrench, its contact frame.
    """
    n = np.array([-slope[0], -slope[1], 1.0]) / np.sqrt(1.0 + slope @ slope)
    along = np.array([np.cos(heading), np.sin(heading)])
    x = np.array([*along, along @ slope]) / np.hypot(1.0, along @ slope)
    aside, R_WC = np.cross(n, x), contact_frame(np.column_stack([x, x, x]))
    toe, heel = (speed * aside if end in ends else np.zeros(3) for end in ("toe", "heel"))
    forces = [normal * n - mu * normal * u / speed for u in (toe, heel)]
    moment = X * np.cross(x, forces[0] - forces[1])
    w = np.cross(x, toe - heel) / (2.0 * X)
    wrench = np.concatenate([forces[0] + forces[1], R_WC[:, 1:].T @ moment])
    return (0.5 * (toe + heel), w), wrench, R_WC


def learned(friction, motion, wrench, R_WC, slope, c):
    """The friction that is believed after a foot with a wrench on it has told of it."""
    R_WS = ground_frame(R_WC, slope)
    return update_friction_estimate(
        friction, motion, forces_on_ground(wrench, R_WC, R_WS, c), R_WS, c
    )


ends = st.sampled_from([("toe",), ("heel",), ("toe", "heel")])


@given(slopes, angles, st.floats(0.3, 0.95), ends)
def test_ends_that_slide_tell_the_friction_of_the_ground(slope, heading, mu, ends):
    """Also where the other end stays and the foot turns about it, with half of the force."""
    told = slide(slope, heading, mu, ends)
    friction = [1.0]
    for _ in range(120):
        friction.append(learned(friction[-1], *told, slope, C))
    assert np.all(np.diff(friction) < 0.0)
    assert friction[-1] == pytest.approx(mu, abs=3e-3)
    assert learned(0.5 * mu, *told, slope, C) > 0.5 * mu


@given(slopes, angles, ends)
def test_a_foot_that_does_not_slide_tells_nothing_of_the_friction(slope, heading, ends):
    (v, w), wrench, R_WC = slide(slope, heading, 0.4, ends)
    for motion, on_it in (
        ((0.3 * v, 0.3 * w), wrench),  # slowly
        ((-v, -w), wrench),  # pushed along
        ((v, w), -wrench),  # in the air
        ((v, w), 0.0 * wrench),
    ):
        assert learned(0.7, motion, on_it, R_WC, slope, C) == 0.7


def test_a_force_across_the_motion_tells_nothing_of_the_friction():
    (v, w), wrench, R_WC = slide(np.zeros(2), 0.3, 0.4, ("toe", "heel"))
    carried = v + 3.0 * R_WC[:, 0], w
    assert learned(0.7, carried, wrench, R_WC, np.zeros(2), C) == 0.7


def test_an_end_without_load_tells_nothing_of_the_friction():
    """The foot turns about the edge of a tile, its toe in the air."""
    motion, wrench, R_WC = slide(np.zeros(2), 0.3, 0.4, ("toe",))
    wrench[3] = X * wrench[2]  # all on the heel
    assert learned(0.7, motion, wrench, R_WC, np.zeros(2), C) == 0.7


def test_ice_is_believed_to_have_a_little_friction():
    told, friction = slide(np.zeros(2), 0.3, 0.01, ("toe", "heel")), 1.0
    for _ in range(200):
        friction = learned(friction, *told, np.zeros(2), C)
    assert friction == 0.3


def test_friction_is_believed_again_after_steps_that_do_not_slide():
    friction = [0.4]
    for _ in range(200):
        friction.append(regain_friction(friction[-1], False))
    assert np.all(np.diff(friction[:80]) > 0.0)
    assert friction[-1] == 1.0
    assert 30 < np.searchsorted(friction, 0.6) < 60  # in some ten seconds
    assert regain_friction(0.4, True) == 0.4


@pytest.mark.parametrize("side", [0, 1])
def test_an_ankle_at_its_stop_tells_nothing_of_what_bears(side):
    c = C.copy()
    c.ankle_limits[:] = [[-0.5, 0.7], [-0.6, 0.8]]
    low, high = c.ankle_limits[side]
    assert is_at_stop(low, side, c)
    assert is_at_stop(high + 0.01, side, c)
    assert not is_at_stop(0.0, side, c)
    robot = PendulumRobot()
    robot.constants = c
    robot.wrench = pressed(HEEL)
    ankle = 0.0

    def at_stop(still=robot.dynamics):
        return still()._replace(q=np.full(7, ankle))

    robot.dynamics = at_stop
    ankle = low
    assert all(
        np.all(t.state.footing.load_shares == 0.5)
        for t in robot.run(COMMAND, 1.0)
        if t.state.clock.side == side
    )
    ankle = 0.0
    assert any(t.state.footing.load_shares[TOE] < 0.1 for t in robot.run(COMMAND, 1.0))
