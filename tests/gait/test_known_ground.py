"""What the gait makes of a map: where a foot stands, where it has room, what it corrects."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from drake_linefoot.gait.command import allowed_command
from drake_linefoot.gait.constants import constants_of
from drake_linefoot.gait.footholds import cop_towards, known_offset
from drake_linefoot.gait.footsteps import (
    StepCommand,
    heading_vector,
    nominal_strides,
)
from drake_linefoot.gait.known_ground import (
    height_at,
    highest_between,
    is_felt,
    is_near_patch,
    level_between,
    patch_at,
    point_of,
    room_of,
    slope_at,
    snapped,
)
from drake_linefoot.gait.next_stance import coming_step
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.gait.patches import moved_inside
from drake_linefoot.gait.pendulum import dcm_offset, propagate_dcm
from drake_linefoot.gait.recovery import is_insufficient
from drake_linefoot.gait.state import new_state
from drake_linefoot.gait.step_program import Step
from drake_linefoot.gait.swing import present_line
from drake_linefoot.gait.swing_foot import begin_swing, fit_swing, set_target
from drake_linefoot.gait.told_ground import (
    correct_heights,
    look_ahead,
    open_patch,
    take_in_terrain,
    told_edges,
)
from drake_linefoot.lab.plants.ground import Ground
from drake_linefoot.lab.plants.patch_ground import outlines, terrain_of
from drake_linefoot.lab.plants.terrain_map import near
from drake_linefoot.lab.results.clearance import shank_clearance
from drake_linefoot.lab.scenario.courses import (
    PatchParameters,
    StairsParameters,
    StonesParameters,
)
from drake_linefoot.lab.scenario.scene import Scene
from drake_linefoot.statuses import Limit
from drake_linefoot.terrain import PATCHES, TERRAIN, Terrain, felt_ground
from tests.helpers.steps import OMEGA, SHAPE, T, constants

RISE = 0.12
STAIRS = Ground(Scene(stairs=StairsParameters(rise=RISE, at=0.5, heading=0.2)))
STONES = Ground(Scene(stones=StonesParameters(at=0.3)))
FEET = constants(SHAPE, half_length=0.075, edge_margin=0.015)
places = st.tuples(st.floats(0.0, 1.6), st.floats(-0.4, 0.4)).map(np.array)
yaws = st.floats(-0.5, 0.5)


def state_on(ground, place=(0.0, 0.0), error=0.0):
    """A robot with both feet at a place of ground that it knows."""
    s = new_state()
    s.clock.lift_off[:] = 1e9
    for foot, aside in enumerate((0.08, -0.08)):
        x, y = place[0], place[1] + aside
        s.robot.feet[foot] = [x, y, ground.height(x, y), 0.0]
    patches = ground.patches()
    patches = patches._replace(sigma=patches.sigma + error)
    take_in_terrain(s, near(outlines(patches), np.array(place), 3.0), FEET)
    return s


def strips(ends, steps, slopes):
    """A map of strips across x between ends [m], each so much higher and steeper than the last."""
    n, half = len(steps), 6.0
    corners, plane, sides = np.zeros((PATCHES, 8, 2)), np.zeros((PATCHES, 3)), np.zeros(PATCHES)
    height = 0.0
    for i in range(n):
        low, high = ends[i], ends[i + 1]
        corners[i, :4] = [[low, -half], [high, -half], [high, half], [low, half]]
        height += steps[i]
        plane[i, 0], plane[i, 1], sides[i] = height - slopes[i] * low, slopes[i], 4
        height += slopes[i] * (high - low)
    return Terrain(np.float64(n), sides, corners, plane, np.zeros(PATCHES))


@given(
    st.lists(st.floats(0.3, 2.0), min_size=1, max_size=6),
    st.lists(st.sampled_from([0.0, 0.0, 0.01, -0.05]), min_size=6, max_size=6),
    st.lists(st.floats(-0.3, 0.3), min_size=6, max_size=6),
    st.floats(-3.0, 8.0),
)
def test_the_way_is_felt_where_ground_goes_on_without_a_step(widths, steps, slopes, x):
    """Where heights near both feet, looked up each 2 mm, neither jump nor end."""
    s, c = new_state(), FEET
    ends = np.concatenate([[-2.0], -2.0 + np.cumsum(widths)])
    s.robot.feet[:, 0], s.robot.feet[:, 1] = [x, x + 0.2], [0.08, -0.08]
    t = strips(ends, steps[: len(widths)], slopes)
    reach = 2.0 * c.com_height
    jumps = np.array([ends[0], *ends[1:-1][np.abs(steps[1 : len(widths)]) > 0.0], ends[-1]])
    away = np.abs(jumps[:, None] - s.robot.feet[:, 0]).min() - reach
    assume(abs(away) > 0.004)  # not between what is looked up
    near = np.arange(x - reach, x + 0.2 + reach, 0.002)
    on = np.searchsorted(ends, near, "right") - 1
    is_ground = np.all((on >= 0) & (on < len(widths)))
    heights = t.plane[on, 0] + t.plane[on, 1] * near if is_ground else np.array([0.0, 1.0])
    goes_on = np.abs(np.diff(heights)).max() < 0.005
    found = open_patch(s, t, told_edges(t), c)
    assert found == (np.searchsorted(ends, x, "right") - 1 if goes_on else -1)


@given(places)
def test_a_point_of_the_ground_is_on_its_patch(place):
    s, z = state_on(STAIRS), float(STAIRS.height(*place))
    patch = patch_at(s, np.array([*place, z]))
    assert height_at(s, patch, 0, place) == pytest.approx(z, abs=1e-9)


@given(places, yaws)
def test_a_snapped_foot_stands_whole_on_one_stone_or_step(place, yaw):
    for ground in (STAIRS, STONES):
        s = state_on(ground, (0.0, 0.0))
        there, patch = snapped(s, place, yaw, FEET)
        along = np.linspace(-0.075, 0.075, 21)[:, None]
        line = there + along * [np.cos(yaw), np.sin(yaw)]
        z = ground.height(line[:, 0], line[:, 1])
        np.testing.assert_allclose(z, height_at(s, patch, 0, there), atol=1e-9)


@given(places, yaws)
def test_a_foot_is_snapped_to_the_nearest_room_of_all(place, yaw):
    """A patch after the other, the first one where two are as near; behind counts double."""
    s, found = state_on(STONES, (0.6, 0.0)), []
    for k in range(int(s.terrain.count)):
        there, is_inside = moved_inside(room_of(s, k, yaw, FEET), place)
        away = there - place
        behind = away @ [np.cos(yaw), np.sin(yaw)] < 0.0
        found.append(np.hypot(*away) * (1.0 + behind) if is_inside else np.inf)
    best = int(np.argmin(found))
    there, patch = snapped(s, place, yaw, FEET)
    assert patch == best
    np.testing.assert_array_equal(there, moved_inside(room_of(s, best, yaw, FEET), place)[0])


@pytest.mark.parametrize(("half", "known"), [(1.9, True), (2.3, False)])
def test_where_no_edge_is_near_it_feels_its_way_from_the_slope_of_the_map_on(half, known):
    """Distances count in heights of the CoM; feet are 8 cm beside the middle of a square."""
    s, h = state_on(STAIRS), float(FEET.com_height)
    square = half * h * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    slope = [0.05, -0.02]
    patch = terrain_of([PatchParameters(corners=square.tolist(), plane=[0.0, *slope])])
    take_in_terrain(s, near(outlines(patch), np.zeros(2), 3.0), FEET)
    assert is_felt(s, 0) != known and s.terrain.count == 1.0
    np.testing.assert_array_equal(slope_at(s, 0), slope)
    s.ground.slope[:] = 0.1  # as feet feel it
    take_in_terrain(s, near(outlines(patch), np.zeros(2), 3.0), FEET)
    np.testing.assert_array_equal(slope_at(s, 0), slope if known else [0.1, 0.1])
    take_in_terrain(s, near(outlines(STAIRS.patches()), np.zeros(2), 3.0), FEET)
    assert not is_felt(s, 0) and s.terrain.count > 1.0


def test_a_stated_error_keeps_feet_so_much_farther_from_edges():
    ends = []
    for error in (0.0, 0.02):
        s = state_on(STAIRS, (0.0, 0.0), error)
        ends.append(snapped(s, np.array([0.5, 0.0]), 0.2, FEET)[0])
    away = heading_vector(-0.2, *(ends[0] - ends[1]))
    np.testing.assert_allclose(away, [-0.02, 0.0], atol=1e-6)


@pytest.mark.parametrize("down", [True, False])
def test_down_a_step_a_foot_is_to_go_lower_by_half_of_what_a_map_may_be_off(down):
    for error in (0.0, 0.02):
        stairs = StairsParameters(rise=-RISE if down else RISE, at=0.2, heading=0.0)
        s = state_on(Ground(Scene(stairs=stairs)), error=error)
        place = np.array([0.35, 0.08])
        patch = patch_at(s, np.array([*place, stairs.rise]))
        set_target(s, 0, place, 0.0, patch)
        assert s.swing.target[0, 2] == pytest.approx(stairs.rise - 0.5 * error * down, abs=1e-9)


def test_a_foot_goes_back_to_where_it_stood_as_high_as_it_stood():
    """Whatever the map says, and how far off that may be."""
    stairs = StairsParameters(rise=-RISE, at=0.2, heading=0.0)
    s, stood = state_on(Ground(Scene(stairs=stairs)), error=0.02), np.array([0.35, 0.08, -0.107])
    s.swing.lifted[0] = stood
    place = stood[:2] + np.array([0.02, 0.0])
    set_target(s, 0, place, 0.0, patch_at(s, stood))
    np.testing.assert_allclose(s.swing.target[0, :3], [*place, stood[2]], atol=1e-9)
    assert height_at(s, patch_at(s, stood), 1, place) == pytest.approx(stood[2], abs=1e-9)
    farther = np.array([0.65, 0.08, -2 * RISE])  # there only the map says how high it is
    assert height_at(s, patch_at(s, farther), 1, farther) == pytest.approx(-2 * RISE, abs=1e-9)


@pytest.mark.parametrize("rise", [0.12, 0.15, 0.18])
def test_a_shank_is_clear_of_the_riser_before_which_a_foot_stands(humanoid, rise):
    """With its ankle bent as far as `shank_lean`, on the tread's last place for a foot."""
    stairs = Ground(Scene(stairs=StairsParameters(rise=rise, at=0.5, tread=[0.28, 0.28])))
    c, s = constants_of(GaitParameters(), humanoid)[0], state_on(stairs)
    tread = patch_at(s, np.array([0.6, 0.0, rise]))
    place, is_inside = moved_inside(room_of(s, tread, 0.0, c), np.array([0.9, 0.0]))
    assert is_inside
    q, (knee, ankle) = humanoid.q_nominal.copy(), (1.0, -float(c.shank_lean))
    q[humanoid.leg_q] = [0.0, 0.0, -knee - ankle, knee, ankle]
    context = humanoid.plant.CreateDefaultContext()
    humanoid.plant.SetPositions(context, q)
    p_WC = humanoid.foot_frames[0].CalcPoseInWorld(context) @ humanoid.p_FC[0]
    q[4:7] += [place[0] - p_WC[0], 0.0, rise - p_WC[2]]
    gap = shank_clearance(humanoid, stairs, q[None])[0]
    assert gap >= 0.0
    if rise > 0.14:  # it keeps no farther away than that
        q[4] += 0.015
        assert shank_clearance(humanoid, stairs, q[None])[0] < 0.0


def test_ground_of_which_nothing_is_known_goes_through_the_stance_foot():
    s = new_state()
    s.robot.feet[0] = [1.0, 2.0, 0.3, 0.1]
    s.ground.slope[:] = [0.1, -0.2]
    take_in_terrain(s, felt_ground(), FEET)
    assert is_felt(s, 0)
    np.testing.assert_array_equal(point_of(s, 0, 0), [1.0, 2.0, 0.3])
    assert height_at(s, 0, 0, np.array([2.0, 3.0])) == pytest.approx(0.3 + 0.1 - 0.2)
    place = np.array([7.0, -3.0])
    np.testing.assert_array_equal(snapped(s, place, 0.4, FEET)[0], place)


@pytest.mark.parametrize(("rise", "told"), [(0.12, 1.2), (-0.12, 1.2), (0.12, 0.4), (0.15, 1.0)])
def test_stairs_that_are_known_are_walked_as_steep_as_they_are(rise, told):
    """Two end 0.5 m ahead: that times the speed is at most 0.25 m/s; floors are as before."""
    c = constants(FEET, step_length=0.28, command_max=[1.5, 0.5, 2.0], climb_max=0.13,
                  stairs_climb_max=0.25, careful_speed=0.3, unevenness_max=0.007, walk_max=1.5,
                  friction_firm=0.6, friction_careful=0.4)  # fmt: skip
    stairs = StairsParameters(rise=rise, at=0.2, heading=0.0, tread=(0.3, 0.3))
    s = state_on(Ground(Scene(stairs=stairs)))
    s.footing.friction, s.command.velocity[0] = 1.0, told
    command = np.array([told, 0.0, 0.0, 1.0])
    look_ahead(s, 0, c)
    fastest = 0.25 / (2.0 * abs(rise) / 0.5)
    allowed, why = allowed_command(s, command, c)
    assert allowed[0] == pytest.approx(min(told, fastest), rel=0.05)
    assert why == (Limit.SLOPED if told > fastest else Limit.FREE)
    take_in_terrain(s, felt_ground(), FEET)
    look_ahead(s, 0, c)
    assert allowed_command(s, command, c) == (pytest.approx(command[:3]), Limit.FREE)


def test_feet_correct_the_height_of_the_map():
    s = state_on(STAIRS)
    s.robot.feet[:, 2] += 0.02
    for _ in range(6):
        correct_heights(s, 0)
    assert s.terrain.offset == pytest.approx(0.02, abs=5e-4)
    step = patch_at(s, np.array([0.65, 0.0, RISE + 0.02]))
    assert height_at(s, step, 0, np.array([0.65, 0.0])) == pytest.approx(RISE + 0.02, abs=1e-3)


@given(st.floats(0.2, 0.8), yaws, st.sampled_from([0, 1]))
def test_strides_over_ground_without_edges_are_those_of_a_steady_walk(speed, yaw, side):
    s, command = new_state(), StepCommand(np.array([speed, 0.0]), 0.1, T)
    take_in_terrain(s, felt_ground(), FEET)
    found = known_offset(s, command, np.zeros(2), yaw, side, SHAPE)
    expected = dcm_offset(nominal_strides(command, SHAPE, yaw, side), OMEGA, T)
    np.testing.assert_array_equal(found, expected)


numbers = st.floats(-0.2, 0.2)


@given(st.tuples(numbers, numbers).map(np.array), st.tuples(numbers, numbers).map(np.array), yaws)
def test_no_centre_of_pressure_within_reach_brings_the_dcm_nearer(xi, aim, yaw):
    foot, reach, time = np.array([0.02, -0.03, 0.0, yaw]), 0.05, 0.2
    cop = cop_towards(xi, aim, foot, OMEGA, time, reach)
    ahead = heading_vector(-yaw, *(cop - foot[:2]))
    assert abs(ahead[0]) <= reach + 1e-12 and abs(ahead[1]) < 1e-12
    best = np.linalg.norm(propagate_dcm(xi, cop, OMEGA, time) - aim)
    for other in np.linspace(-reach, reach, 21):
        tried = foot[:2] + heading_vector(yaw, other, 0.0)
        assert best <= np.linalg.norm(propagate_dcm(xi, tried, OMEGA, time) - aim) + 1e-9


@pytest.mark.parametrize(("from_x", "to_x", "pitch"), [(0.6, 0.9, 0.2), (0.9, 0.6, 0.0)])
def test_up_a_step_a_foot_goes_on_its_toe_which_does_not_go_down(from_x, to_x, pitch):
    place, lands = (np.array([x, 0.08, STAIRS.height(x, 0.08)]) for x in (from_x, to_x))
    s, c = state_on(STAIRS, (from_x, 0.0)), constants(SHAPE, half_length=0.075, toe_off=0.0)
    s.clock.lift_off[0] = 0.0
    begin_swing(s, 0, c)
    s.swing.target[0, :3] = lands
    fit_swing(s, 0, c)
    duration, heel = 0.2, s.swing.heel[0]
    lines = [present_line(s.swing.reference[0], 0.05, heel, duration, t)
             for t in np.linspace(0.0, duration, 81)]  # fmt: skip
    toes, heels = (np.array([line[0, 2] + side * line[3, 2] for line in lines])
                   for side in (c.half_length, -c.half_length))  # fmt: skip
    assert np.all(toes >= place[2] - 1e-4)
    assert np.arcsin((heels - toes) / (2.0 * c.half_length)).max() == pytest.approx(pitch, abs=1e-3)
    assert heels[-1] == pytest.approx(toes[-1], abs=1e-12)


@given(st.permutations(range(6)))
def test_a_map_whose_patches_are_numbered_anew_changes_nothing_of_a_swing(order):
    s = state_on(STAIRS, (0.6, 0.0))
    s.clock.lift_off[0] = 0.0
    begin_swing(s, 0, FEET)
    s.swing.target[0] = [0.9, 0.08, 2 * RISE, 0.0, 0.0]
    fit_swing(s, 0, FEET)
    step = s.swing.step[0]
    patches = STAIRS.patches()
    vector = near(outlines(patches), np.array([0.6, 0.0]), 3.0)
    known = TERRAIN.open(vector)
    mixed = [*order, *range(len(order), int(known.number))]
    for each in (known.sides, known.corners, known.plane, known.sigma):
        each[: len(mixed)] = each[mixed]
    take_in_terrain(s, vector, FEET)
    fit_swing(s, 0, FEET)
    assert s.swing.step[0] == step == 1.0


def test_a_swing_is_higher_over_what_is_higher_than_both_its_ends():
    s, known = new_state(), TERRAIN.open(vector := np.zeros(TERRAIN.size))
    for k, (begin, end, z) in enumerate([(-0.3, 0.1, 0.0), (0.1, 0.15, 0.05), (0.15, 0.6, 0.0)]):
        known.sides[k], known.plane[k, 0] = 4, z
        known.corners[k, :4] = [[begin, -1.0], [end, -1.0], [end, 1.0], [begin, 1.0]]
    for count, height in ((3.0, 0.05), (1.0, 0.0)):
        vector[TERRAIN.place("number")] = count
        s.clock.lift_off[:] = [0.0, 1e9]
        take_in_terrain(s, vector, FEET)
        begin_swing(s, 0, FEET)
        s.swing.target[0] = [0.3, 0.0, 0.0, 0.0, 0.0]
        s.swing.height[0] = FEET.swing_height
        assert highest_between(s, s.swing.lifted[0], s.swing.target[0]) == height
        fit_swing(s, 0, FEET)
        assert s.swing.height[0] == pytest.approx(FEET.swing_height + height)


@pytest.mark.parametrize(("above", "met"), [(0.03, True), (0.06, False)])
def test_contact_far_above_the_ground_a_foot_is_to_land_on_is_that_of_an_edge(above, met):
    s = state_on(STAIRS, (0.6, 0.0))
    line = np.array([0.65, 0.08, RISE + above, 0.0])
    s.terrain.under[0] = patch_at(s, np.array([0.65, 0.08, RISE]))
    assert is_near_patch(s, 0, line, -2.0, FEET) == met


def test_what_the_centre_of_pressure_brings_does_not_hurry_the_next_step():
    s = state_on(STAIRS, (0.6, 0.0))
    s.command.velocity[0] = 0.4
    s.robot.com[:2] = s.robot.pendulum_com[:2] = [0.6, 0.0]
    x = coming_step(s, 0, 0.0, FEET)
    assert len(x.room) == 4 and x.pressure == FEET.cop_reach
    tau = np.exp(FEET.omega * (0.2 + x.switch))
    ahead = np.array([FEET.short_step + FEET.cop_reach * (tau - 1.0), 0.0])
    for off, short in ((0.99, False), (1.01, True)):
        step = Step(0.2, x.dcm * tau - x.offset + off * ahead, True, 0.0, False)
        assert is_insufficient(x, step, FEET) == short


def test_the_body_goes_up_with_the_lower_foot_and_down_a_step_less():
    assert level_between(0.0, 0.12) == 0.0
    assert level_between(0.12, 0.12) == 0.12
    assert level_between(0.12, 0.0) == pytest.approx(0.4 * 0.12)
