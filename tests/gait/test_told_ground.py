"""What is kept of a map: where none is needed, how steep it is ahead, what feet correct."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from drake_linefoot.gait.command import allowed_command
from drake_linefoot.gait.known_ground import height_at, is_felt, patch_at, slope_at
from drake_linefoot.gait.state import new_state
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
from drake_linefoot.lab.scenario.courses import PatchParameters, StairsParameters
from drake_linefoot.lab.scenario.scene import Scene
from drake_linefoot.statuses import Limit
from drake_linefoot.terrain import PATCHES, Terrain, felt_ground
from tests.helpers.known_ground import FEET, RISE, STAIRS, state_on
from tests.helpers.steps import constants


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
