"""The program that chooses where and when the swing foot lands."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from drake_linefoot.gait.constants import gait_constants
from drake_linefoot.gait.footsteps import StepCommand, heading_vector
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.gait.step_program import (
    AHEAD,
    BEHIND,
    OWN_SIDE,
    StepProblem,
    best_foothold,
    is_beside,
    passing_bound,
    solve_step,
)
from drake_linefoot.gait.swing import base_motion
from drake_linefoot.gait.touchdown import step_problem, update_foothold
from drake_linefoot.gait.viability import (
    StepBounds,
    is_viable,
    offset_limits,
    viable_offsets,
)
from drake_linefoot.robot.description import StepLimits
from tests.helpers.pendulum_robot import ANKLES
from tests.helpers.phases import phase_end, set_swing, swing_of
from tests.helpers.steps import (
    ACCELERATION,
    ANYWHERE,
    LENGTH_MAX,
    OMEGA,
    SHAPE,
    WIDTH_MAX,
    WIDTH_MIN,
    ZERO,
    T,
    cases,
    constants,
    swing_state,
)

OWN = constants(SHAPE, crossing_max=0.0)  # never to the other side of the stance foot
QUICKEST_STEP = OWN.swing_time_min + OWN.double_support_min  # [s]
QUICKEST = viable_offsets(QUICKEST_STEP, OWN.step_limits, OMEGA)
FREE = constants(
    OWN, reach_limits=[99.0, 99.0], swing_acceleration=[1e6, 1e6, 1e6], offset_limits=QUICKEST
)
SHORT = constants(SHAPE, half_length=0.075)  # feet
CLEAR, GAP = 2.0 * SHORT.half_length + SHORT.crossing_gap, SHORT.crossing_gap
OFFSET, FOOT = np.array([0.05, 0.05]), np.array([0.0, 0.16])
near = st.tuples(st.floats(-0.3, 0.3), st.floats(-0.1, 0.3)).map(np.array)


def problem(dcm, com=ZERO, velocity=ZERO, times=(0.1, 0.1, 0.05, 0.15, 0.15), c=SHAPE):
    """A swing whose foot is at rest where it was lifted; times as in `StepProblem`."""
    at_rest, most, last = (FOOT, ZERO, FOOT), c.swing_acceleration[:2], (c.switch, c.settle_time)
    return StepProblem(dcm, com, velocity, *at_rest, OFFSET, most, *times, *last, ZERO, *ANYWHERE)


@given(near, near, near)
def test_a_foothold_is_within_every_bound_at_a_time_that_is_given(com, velocity, foot):
    """Reach of stance foot and CoM, and the acceleration of the quintic that gets there."""
    remaining = 0.12
    times = (remaining,) * 5
    dcm = com + velocity / OMEGA
    foot = FOOT + 0.1 * foot
    x = problem(dcm, com, velocity, times)._replace(foot=foot, target=foot)
    when, u, *_ = solve_step(x, OWN)
    assert when == pytest.approx(remaining, abs=1e-9)
    landing = solve_ivp(
        lambda t, y: [*y[2:], *OMEGA**2 * y[:2]],
        (0.0, remaining), [*com, *velocity], rtol=1e-11, atol=1e-12,
    ).y[:2, -1]  # fmt: skip
    reference, target = np.zeros((3, 5)), np.zeros(5)
    reference[0, :2], target[:2] = x.foot, u
    left = remaining - SHAPE.settle_time
    motion = base_motion(reference, target, left, np.linspace(0.0, left, 101))
    peak = np.abs(motion[2, :, :2]).max(axis=0)
    assert np.all(peak <= SHAPE.swing_acceleration[:2] * 1.001)
    reachable = np.abs(landing[0]) < 0.2 and -0.1 < landing[1] < 0.2
    if reachable and lost_by(u, remaining, x, OWN) <= 0.0:
        # A bound with a slack of weight 100 gives way by a hundredth of what it holds back.
        nominal = dcm * np.exp(OMEGA * (remaining + OWN.switch)) - OFFSET
        gives = 0.01 * np.abs(nominal - u) + 1e-6
        assert abs(u[0] - landing[0]) <= SHAPE.reach_limits[0] + gives[0]
        assert u[1] - landing[1] <= SHAPE.reach_limits[1] + gives[1]
        assert WIDTH_MIN - gives[1] <= u[1] <= WIDTH_MAX + gives[1]


@given(st.tuples(st.floats(-8.0, 8.0), st.floats(-6.0, 6.0)).map(np.array), near, near)
def test_a_moving_foot_is_not_braked_harder_than_its_leg_can(speed, dcm, target):
    """But for what it needs to go where it is on its way to, in the time that is planned."""
    x = problem(dcm, times=(0.12, 0.12, 0.06, 0.2, 0.2))._replace(
        foot_velocity=speed, target=target
    )
    when, u, *_ = solve_step(x, OWN)
    reference = np.zeros((3, 5))
    reference[0, :2], reference[1, :2] = FOOT, speed

    def peak(place, remaining):
        goal, left = np.array([*place, 0.0, 0.0, 0.0]), remaining - OWN.settle_time
        motion = base_motion(reference, goal, left, np.linspace(0.0, left, 201))
        return np.abs(motion[2, :, :2]).max(axis=0)

    limit = 1.15 * OWN.swing_acceleration[:2]  # taken where it peaks from rest
    if when >= 0.12 - 1e-9:
        limit = np.maximum(limit, peak(target, 0.12) + 1e-6)
    assert np.all(peak(u, when) <= limit)


@given(cases)
def test_a_world_that_is_turned_and_moved_asks_for_the_same_step(case):
    com, velocity, stance, yaw, side, command = case
    shift, turn = np.array([0.7, -0.3]), 0.9

    def moved(p):
        return shift + heading_vector(turn, *p)

    other = (moved(com), heading_vector(turn, *velocity), moved(stance), yaw + turn, side, command)
    one, two = swing_state(case), swing_state(other)
    swing_of(two).reference[0, :2] = swing_of(two).target[:2] = shift
    for s in (one, two):
        set_swing(s, 0.0, 0.1)
    problems = step_problem(one, side, yaw, 0, SHAPE), step_problem(two, side, yaw + turn, 0, SHAPE)
    for a, b in zip(*problems, strict=True):
        np.testing.assert_allclose(a, b, atol=1e-9)


@pytest.mark.parametrize("direction", np.arange(8) * 0.25 * np.pi)
@pytest.mark.parametrize("side", [0, 1])
def test_a_sooner_step_leaves_less_of_a_push(side, direction):
    """A robot that steps in place and is pushed by 0.8 m/s, just after lift-off."""
    stance, swing = np.array([0.0, (-0.08, 0.08)[side]]), np.array([0.0, (0.08, -0.08)[side]])
    velocity = heading_vector(direction, 0.8, 0.0)

    def left(c, shortest):
        case = (ZERO, velocity, stance, 0.0, side, StepCommand(ZERO, 0.0, T))
        s = swing_state(case, slope=ZERO)
        swing_of(s).reference[0, :2] = swing_of(s).target[:2] = swing
        set_swing(s, 0.0, 0.19)
        update_foothold(s, side, constants(c, swing_time_min=shortest))
        xi = stance + (velocity / OMEGA - stance) * np.exp(OMEGA * (phase_end(s) + c.switch))
        return np.linalg.norm(xi - swing_of(s).target[:2]), phase_end(s)

    (planned, full), (less, when) = left(SHAPE, 0.19), left(SHAPE, 0.1)
    assert full == pytest.approx(0.19, abs=1e-9)
    assert 0.1 - 1e-9 <= when < full
    assert less < planned


# --- to the other side, and later --------------------------------------------------------

ways = st.tuples(st.floats(-0.6, 0.6), st.floats(-0.2, 0.4)).map(np.array)


def meets(start, end):
    """Whether a straight way comes into the box about the stance foot, looked at in 2001 places."""
    way = start + np.linspace(0.0, 1.0, 2001)[:, None] * (end - start)
    return bool(np.any((np.abs(way[:, 0]) < CLEAR - 1e-4) & (way[:, 1] < GAP - 1e-4)))


@given(ways, ways, st.sampled_from([AHEAD, BEHIND]))
def test_a_way_within_its_bound_goes_around_the_stance_foot(start, end, where):
    near = min(start[1] + WIDTH_MIN - GAP, end[1]) < WIDTH_MIN
    if start[1] < GAP:  # it has crossed on the side where it is
        where = AHEAD if start[0] > 0.0 else BEHIND
    bound = passing_bound(start, end[1], where, SHORT)
    assert near or bound == -np.inf
    if start[1] < GAP and where * start[0] < CLEAR:
        return  # it is in the box
    if where * end[0] >= bound:
        assert not meets(start, end)
    elif start[1] > GAP > end[1] + 0.01 and -CLEAR < where * end[0] < bound - 0.01:
        assert meets(start, end)


@pytest.mark.parametrize(
    ("foot", "outward", "where", "bound"),
    [
        ([-0.3, 0.16], 0.2, AHEAD, -np.inf),  # it stays on its own side
        ([0.3, 0.02], 0.01, AHEAD, 0.2),  # across, where it stays
        ([0.1, 0.02], 0.16, AHEAD, -np.inf),  # beside the stance foot, on its way out
        (
            [0.3, 0.0],
            0.15,
            AHEAD,
            0.0,
        ),  # on its way back: after a third it is at the gap, 0.2 ahead
        ([0.3, 0.0], 0.15, BEHIND, -np.inf),
        ([-0.2, 0.15], -0.05, AHEAD, 0.6),  # after half its way it is at the gap
        ([-0.3, 0.15], -0.05, BEHIND, 0.2),  # 0.1 there, and then beyond the foot
        ([0.1, 0.05], -0.05, AHEAD, 100.1),  # at the gap already: no way
    ],
)
def test_a_way_passes_the_corner_of_the_stance_foot(foot, outward, where, bound):
    """Feet 15 cm long with 5 cm between them: the corner is 0.2 m away, at 0.05 m outward."""
    assert (CLEAR, GAP) == (pytest.approx(0.2), 0.05)
    found = passing_bound(np.array(foot), outward, where, SHORT)
    assert found == pytest.approx(bound, abs=1e-9)


@pytest.mark.parametrize(
    ("u", "beside"),
    [
        ([0.0, 0.04], True), ([0.0, 0.06], False), ([0.19, -0.05], True), ([-0.19, 0.04], True),
        ([0.21, 0.04], False), ([-0.21, -0.05], False), ([0.3, 0.2], False),
    ],
)  # fmt: skip
def test_a_foot_is_beside_the_other_within_its_length_and_the_gap(u, beside):
    assert is_beside(np.array(u), SHORT) == beside


def lost_by(foothold, remaining, x, c):
    """How far the DCM is outside the bounds of those that steps save, after a step [m]."""
    b = x.dcm * np.exp(OMEGA * (remaining + c.switch)) - foothold
    b[1] = -b[1]
    bounds = c.offset_limits
    return float(np.maximum(bounds[:, 0] - b, b - bounds[:, 1]).max())


def test_offsets_are_those_that_legs_can_make():
    """With strong legs those of the quickest step; else of the best time for a foot's way.

    Of recovery steps, which follow an insufficient one.
    """
    idle = SHAPE.double_support_min + SHAPE.settle_time_min
    steps = QUICKEST_STEP, idle, OWN.step_limits[:]
    strong = offset_limits(*steps, np.array([1e6, 1e6]), OMEGA)
    np.testing.assert_allclose(strong, QUICKEST, rtol=1e-12)
    T = np.arange(QUICKEST_STEP, 0.8, 0.002)
    E, ahead, aside = np.exp(OMEGA * T), *SHAPE.swing_acceleration[:2, None] * (T - idle) ** 2
    length = np.minimum(LENGTH_MAX, 0.5 * ahead * np.sqrt(3.0) / 10.0)
    wide = np.minimum(WIDTH_MAX, WIDTH_MIN + aside * np.sqrt(3.0) / 10.0)
    (back, front), (out, inwards) = SHAPE.offset_limits
    assert [-back, front] == pytest.approx(2 * [np.max(length / (E - 1.0))], rel=1e-9)
    # From a bound, the narrowest and the widest step in turn lead back to it; no time to more.
    for bound, first, then, best in (
        (inwards, wide, WIDTH_MIN, np.argmin), (out, WIDTH_MIN, wide, np.argmax)
    ):  # fmt: skip
        after = then - E * (first - E * bound)
        k = best(after - bound)
        assert after[k] == pytest.approx(bound, abs=1e-9)
    assert np.all(np.abs(SHAPE.offset_limits) < np.abs(QUICKEST))


def test_without_recovery_steps_offsets_are_those_of_steady_steps():
    p, limits = GaitParameters(recovery_steps=0), StepLimits(0.5, 0.1, 0.45, 0.56, 0.68)
    c = gait_constants(p, limits, (0.1, 0.0, 0.0), ACCELERATION, ANKLES)[0]
    times = c.swing_time_min + c.double_support, c.double_support + c.settle_time
    steady = offset_limits(*times, c.step_limits[:], ACCELERATION, float(c.omega))
    np.testing.assert_array_equal(c.offset_limits, steady)
    recovering = gait_constants(GaitParameters(), limits, (0.1, 0.0, 0.0), ACCELERATION, ANKLES)[
        0
    ].offset_limits
    assert np.all(np.abs(steady) < np.abs(recovering))


@given(st.tuples(st.floats(-1.0, 1.0), st.floats(-0.5, 0.8)).map(np.array))
def test_a_step_is_lost_where_no_steps_after_it_save_the_pendulum(dcm):
    """By `is_viable`, seen from the foot that has landed, whose next foot is on the other side."""
    limits = FREE.step_limits[:]
    bounds = StepBounds(OMEGA, QUICKEST_STEP, limits, viable_offsets(QUICKEST_STEP, limits, OMEGA))
    u = np.empty(2)
    _, _, lost = best_foothold(problem(dcm, c=FREE), 0.1, OWN_SIDE, FREE, u)
    after = (dcm * np.exp(OMEGA * (0.1 + FREE.switch)) - u) * [1.0, -1.0]
    saved = [is_viable(s * after, bounds.duration, bounds) for s in (1.0 - 1e-6, 1.0 + 1e-6)]
    assert lost in {not one for one in saved}


def test_a_swing_lasts_longer_where_its_foot_would_land_too_near():
    """A push outward, 60 ms before touchdown; the foot is fast, and on its way to 0.31 m."""
    dcm, com, times = np.array([0.21, 0.34]), np.array([0.11, 0.17]), (0.06,) * 5
    x = problem(dcm, com, OMEGA * (dcm - com), times)
    x = x._replace(
        foot=np.array([0.12, 0.28]), foot_velocity=np.array([3.0, 2.5]),
        target=np.array([0.18, 0.31]), offset=np.array([0.1, 0.0]),
    )  # fmt: skip
    when, u, *_ = solve_step(x, OWN)
    assert when == pytest.approx(0.06)
    assert lost_by(u, when, x, OWN) > 0.01
    when, u, *_ = solve_step(x._replace(latest=0.12), OWN)
    assert 0.06 < when <= 0.12 + 1e-9
    assert lost_by(u, when, x, OWN) <= 1e-3
    calm = x._replace(dcm=np.array([0.21, 0.17]), latest=0.12)  # not lost: it does not wait
    assert solve_step(calm, OWN)[0] == pytest.approx(0.06)


@given(near, st.floats(-0.25, 0.25))
def test_a_foot_crosses_only_where_no_other_step_saves_the_robot(dcm, ahead):
    foot = np.array([ahead, 0.16])
    x = problem(dcm)._replace(foot=foot, target=foot)
    (when, u, *_), (crossed_when, crossed, *_) = solve_step(x, OWN), solve_step(x, SHORT)
    if lost_by(u, when, x, SHORT) <= 0.0:
        np.testing.assert_array_equal(crossed, u)
    if not np.array_equal(crossed, u):
        assert crossed[1] >= -SHORT.crossing_max - 1e-9
        assert not meets(foot, crossed)
        assert lost_by(crossed, crossed_when, x, SHORT) < lost_by(u, when, x, SHORT)


@pytest.mark.parametrize("ahead", [-0.25, 0.25])
def test_a_foot_that_is_past_the_stance_foot_crosses_after_a_push_to_that_side(ahead):
    foot = np.array([ahead, 0.14])
    x = problem(np.array([0.0, -0.16]))._replace(foot=foot, target=foot)
    _, u, moved, *_ = solve_step(x, SHORT)
    assert moved
    assert u[1] < 0.0
    assert u[0] * np.sign(ahead) >= CLEAR - 1e-9


@pytest.mark.parametrize("left", [0.07, 0.08, 0.09])
@pytest.mark.parametrize("dcm", [[-0.1, -0.05], [-0.05, -0.05], [-0.1, -0.02]])
def test_a_foot_on_its_way_across_goes_on_where_it_could_not_stop_before(dcm, left):
    """On its own side it would land beside the stance foot, nearer than the gap."""
    x = problem(np.array(dcm), times=(left, left, left, left, 1.2 * left))._replace(
        foot=np.array([-0.25, 0.25]),
        foot_velocity=np.array([0.5, -5.0]),
        target=np.array([-CLEAR - 0.01, -0.07]),
    )
    _, u, *_ = solve_step(x, SHORT)
    assert u[1] >= GAP or abs(u[0]) >= CLEAR - 1e-9


def test_a_foot_that_has_crossed_goes_back_around_the_stance_foot():
    foot = np.array([-CLEAR - 0.02, -0.08])
    x = problem(np.array([0.1, 0.3]))._replace(foot=foot, target=foot)
    _, u, *_ = solve_step(x, SHORT)
    assert u[1] >= WIDTH_MIN
    assert not meets(foot, u)
