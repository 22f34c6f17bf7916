"""What the gait makes of a map: where a foot stands, and where it has room."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_linefoot.gait.constants import constants_of
from drake_linefoot.gait.footholds import cop_towards, known_offset
from drake_linefoot.gait.footsteps import StepCommand, heading_vector, nominal_strides
from drake_linefoot.gait.known_ground import (
    height_at,
    highest_between,
    is_felt,
    is_near_patch,
    level_between,
    patch_at,
    point_of,
    room_of,
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
from drake_linefoot.gait.told_ground import take_in_terrain
from drake_linefoot.lab.plants.ground import Ground
from drake_linefoot.lab.plants.patch_ground import outlines
from drake_linefoot.lab.plants.terrain_map import near
from drake_linefoot.lab.results.clearance import shank_clearance
from drake_linefoot.lab.scenario.courses import StairsParameters, StonesParameters
from drake_linefoot.lab.scenario.scene import Scene
from drake_linefoot.terrain import TERRAIN, felt_ground
from tests.helpers.known_ground import FEET, RISE, STAIRS, state_on
from tests.helpers.steps import OMEGA, SHAPE, T, constants

STONES = Ground(Scene(stones=StonesParameters(at=0.3)))
places = st.tuples(st.floats(0.0, 1.6), st.floats(-0.4, 0.4)).map(np.array)
yaws = st.floats(-0.5, 0.5)


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
