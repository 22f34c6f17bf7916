"""Courses: where their ground is, and what a controller is told of it."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from drake_linefoot.errors import ScenarioError
from drake_linefoot.gait.patches import edges_of, outside
from drake_linefoot.lab.plants.ground import Ground
from drake_linefoot.lab.plants.patch_ground import outlines, terrain_of
from drake_linefoot.lab.plants.terrain_map import TerrainMap, erring, near
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.scenario.courses import (
    BlocksParameters,
    GapsParameters,
    PatchParameters,
    SpiralParameters,
    StairsParameters,
    StonesParameters,
    TerrainParameters,
)
from drake_linefoot.lab.scenario.load import make_scenario
from drake_linefoot.lab.scenario.scene import Scene
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.terrain import PATCHES, TERRAIN

TURNED = {"heading": 0.3, "at": 0.7}
SCENES = {
    "stairs": Scene(stairs=StairsParameters(rise=-0.1, tread=[0.25, 0.3], **TURNED)),
    "gaps": Scene(gaps=GapsParameters(**TURNED)),
    "stones": Scene(stones=StonesParameters(**TURNED)),
    "blocks": Scene(blocks=BlocksParameters(**TURNED)),
}


def along(ground, x):
    """Heights on the middle line of a course that begins at 0.7 m, turned by 0.3 rad."""
    return ground.height(0.7 + np.cos(0.3) * np.asarray(x), np.sin(0.3) * np.asarray(x))


def told(ground, place):
    """Heights of the patches that are on a place, by their own planes."""
    found, patches = [], ground.patches()
    for corners, plane in zip(patches.corners, patches.plane, strict=True):
        edges = np.empty((4, 3))
        edges_of(corners, 4, edges)
        if outside(edges, place) <= -1e-6:
            found.append(plane @ [1.0, *place])
    return found


def test_stairs_rise_by_their_height_at_each_tread():
    ground = Ground(SCENES["stairs"], seed=2)
    z = along(ground, np.linspace(-1.0, 3.0, 4001))
    levels, begins = np.unique(np.round(z, 9), return_index=True)
    np.testing.assert_allclose(levels, -0.1 * np.arange(6, -1, -1), atol=1e-9)
    treads = -np.diff(begins)[1:-1] * 1e-3
    assert np.all((treads > 0.249) & (treads < 0.301)) and np.ptp(treads) > 0.005


def test_there_is_nothing_in_a_gap():
    ground, x = Ground(SCENES["gaps"]), np.linspace(-0.5, 3.5, 4001)
    missing = x[np.isinf(along(ground, x))]
    expected = np.concatenate([k * 0.7 + x[(x > 1e-6) & (x < 0.2 - 1e-6)] for k in range(4)])
    assert len(missing) == pytest.approx(len(expected), abs=4)
    assert ground.plane(0.75, 0.0) == 0.0  # of what is nearest


@pytest.mark.parametrize("name", SCENES)
def test_patches_are_the_ground(name):
    """A place has one patch, at its height, or is an edge, or has none."""
    ground, random = Ground(SCENES[name], seed=1), np.random.default_rng(3)
    hits = 0
    for x, y in random.uniform([-0.5, -1.2], [3.5, 1.2], (300, 2)):
        z, heights = float(ground.height(x, y)), told(ground, np.array([x, y]))
        if name == "blocks" and len(heights) > 1:  # tilted ones overlap by millimetres
            continue
        assert len(heights) <= 1
        if heights:
            hits += 1
            assert heights[0] == pytest.approx(z, abs=1e-9) or name == "blocks"
            assert heights[0] <= z + 1e-9
    assert hits > 100


def test_errors_are_within_what_is_said():
    true = Ground(SCENES["stairs"]).patches()
    off = erring(
        true,
        TerrainParameters("scene", noise=0.02, offset=[0.1, 0.0, 0.0], error=0.03),
        np.random.default_rng(0),
    )
    moved = off.corners - true.corners - [0.1, 0.0]
    assert 0.01 < np.abs(moved).max() <= 0.02
    np.testing.assert_allclose(np.ptp(moved, axis=1), 0.0, atol=1e-12)
    assert 0.0 < np.abs(off.plane[:, 0] - true.plane[:, 0]).max() <= 0.02
    np.testing.assert_array_equal(off.sigma, 0.03)


def test_the_nearest_patches_are_told():
    ground = Ground(Scene(stones=StonesParameters(rows=12)))
    every = ground.patches()
    here = np.array([2.0, 0.1])
    some = TERRAIN.open(near(outlines(every), here, 3.0))
    assert some.number == PATCHES < every.number
    middles = every.corners.mean(axis=1)
    farthest = np.linalg.norm(some.corners[:, :4].mean(axis=1) - here, axis=1).max()
    left_out = [m for m in middles if not np.any(np.all(some.corners[:, :4].mean(axis=1) == m, 1))]
    assert min(np.linalg.norm(m - here) for m in left_out) > farthest - 0.15
    few = TERRAIN.open(near(outlines(every), here, 0.2))
    assert 1 <= few.number < 8


def test_distances_are_those_of_the_edges_of_each_patch():
    """Of three, five and four corners, some given clockwise."""
    corners = [
        [[0.0, 0.0], [1.0, 0.1], [0.0, 1.0]],
        [[2.0, 0.0], [3.0, 0.0], [3.2, 0.7], [2.5, 1.3], [1.7, 0.5]],
        [[4.0, 0.0], [4.0, 1.0], [5.0, 1.0], [5.0, 0.0]],
    ]
    patches = terrain_of([PatchParameters(corners=some) for some in corners])
    random = np.random.default_rng(1)
    places = random.uniform((-1.0, -1.0), (6.0, 2.0), (200, 2))
    found = outlines(patches).distances(places)
    for k, some in enumerate(corners):
        a, middle = np.array(some), np.mean(some, axis=0)
        along = np.roll(a, -1, axis=0) - a
        along /= np.linalg.norm(along, axis=1)[:, None]
        left = np.stack([-along[:, 1], along[:, 0]], axis=1)
        inwards = left * np.sign(np.sum((middle - a) * left, axis=1))[:, None]
        away = np.max(-np.sum((places[:, None] - a) * inwards, axis=-1), axis=1)
        np.testing.assert_allclose(found[:, k], away, atol=1e-12)


def test_a_map_is_told_as_late_as_it_is_said(humanoid):
    known = TerrainParameters("scene", range=0.3, delay=0.1)
    stones = Ground(Scene(stones=StonesParameters(rows=12)))
    block = TerrainMap(humanoid, stones, Scenario(terrain=known))
    simulator = Simulator(block)
    context, x = simulator.get_mutable_context(), humanoid.x_nominal.copy()
    said = []
    for place, until in ((0.0, 0.05), (2.0, 0.13), (2.0, 0.2)):
        x[4] = place
        block.GetInputPort("state").FixValue(context, x)
        simulator.AdvanceTo(until)
        said.append(TERRAIN.open(block.GetOutputPort("terrain").Eval(context)))
    np.testing.assert_array_equal(said[0].corners, said[1].corners)
    assert said[2].corners[: int(said[2].number), :4, 0].min() > 1.0 > said[0].corners[0, 0, 0]


@pytest.mark.parametrize(
    ("ground", "message"),
    [
        ({"stairs": {"rise": 2.0}}, "ground.stairs.rise = 2.0: must be"),
        ({"stairs": {"tread": [0.3, 0.2]}}, "ground.stairs.tread = [0.3, 0.2]: must be two depths"),
        ({"stairs": {}, "gaps": {}}, "ground.gaps = 'given': must be none beside another course"),
        ({"stairs": {}, "slope": 0.1}, "ground.stairs = 'given': must be none beside"),
        ({"spiral": {"width": 4.0}}, "ground.spiral.width = 4.0: must be below 4"),
        ({"spiral": {"steps": 60}}, "ground.spiral.steps = 60: must make three quarters"),
        ({"stones": {"rows": 0}}, "ground.stones.rows = 0: must be"),
    ],
)
def test_bad_courses_are_refused_in_a_line(ground, message):
    with pytest.raises(ScenarioError, match="ground") as caught:
        build_closed_loop(make_scenario({"ground": ground}, "a.yaml"))
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_spiral_stair_turns_and_rises_by_its_steps():
    course = SpiralParameters(at=0.7, heading=0.3, rise=0.1, tread=0.28, steps=6, radius=1.5)
    ground = Ground(Scene(spiral=course))
    turn = np.array([[np.cos(0.3), -np.sin(0.3)], [np.sin(0.3), np.cos(0.3)]])
    angle = np.linspace(-0.05, 5.5, 800) * 0.28 / 1.5
    arc = np.column_stack([np.sin(angle), 1.0 - np.cos(angle)])
    places = [0.7, 0.0] + 1.5 * arc @ turn.T
    steps = np.clip(np.floor(angle * 1.5 / 0.28) + 1.0, 0, 6)
    np.testing.assert_allclose(ground.height(*places.T), 0.1 * steps, atol=1e-12)
    end = 5 * 0.28 / 1.5
    ahead = places[-1] + 3.0 * turn @ [np.cos(end), np.sin(end)]
    assert ground.height(*ahead) == pytest.approx(0.6)
    assert ground.height(*([0.7, 0.0] + turn @ [0.0, 1.5])) == -np.inf  # its axis


def test_ground_is_known_at_times_that_are_said(humanoid):
    known = TerrainParameters("scene", known=[[0.1, 0.2], [0.3, 0.4]])
    block = TerrainMap(humanoid, Ground(SCENES["stairs"]), Scenario(terrain=known))
    simulator = Simulator(block)
    context = simulator.get_mutable_context()
    block.GetInputPort("state").FixValue(context, humanoid.x_nominal)
    seen = []
    for time in (0.05, 0.15, 0.25, 0.35, 0.45):
        simulator.AdvanceTo(time)
        seen.append(TERRAIN.open(block.GetOutputPort("terrain").Eval(context)).sides[0])
    assert seen == [0.0, 4.0, 0.0, 4.0, 0.0]


@pytest.mark.parametrize(
    ("terrain", "message"),
    [
        ({"known": [[1.0, 1.0]]}, "terrain.known[0]"),
        ({"source": "file"}, "terrain.file = None: must be given where `source` is file"),
        ({"source": "scene", "file": "a.yaml"}, "and only there"),
    ],
)
def test_bad_entries_of_terrain_are_refused_in_a_line(terrain, message):
    with pytest.raises(ScenarioError) as caught:
        build_closed_loop(make_scenario({"terrain": terrain}, "a.yaml"))
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)
