"""The shape of the ground: as Drake's own queries see it, level where the robot starts."""

import numpy as np
import pytest
from pydrake.geometry import Role
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from drake_linefoot.errors import ScenarioError
from drake_linefoot.lab.plants.ground import EDGE, Ground, slope_axes
from drake_linefoot.lab.plants.scene import add_ground, ground_of, own_friction
from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.scenario.courses import PatchParameters, StairsParameters
from drake_linefoot.lab.scenario.disturbances import GroundParameters
from drake_linefoot.lab.scenario.scene import Scene, load_scene, scene_of
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop

TEN = np.deg2rad(10.0)
SMALL = {"tiled": [4.0, 4.0]}
SCENES = {
    "flat": Scene(),
    "up": Scene(slope=TEN),
    "down": Scene(slope=TEN, slope_heading=np.pi),
    "left": Scene(slope=TEN, slope_heading=0.5 * np.pi),
    "down to the right": Scene(slope=0.12, slope_heading=2.2),
    "step up": Scene(ledge_height=0.03, ledge_at=0.8),
    "step down": Scene(ledge_height=-0.03, ledge_at=0.8),
    "rough": Scene(step_height=0.03, **SMALL),
    "small tiles": Scene(step_height=0.05, tile=0.3, **SMALL),
    "rough slope": Scene(slope=TEN, slope_heading=0.4, step_height=0.03, **SMALL),
}


def places(n=300, reach=1.9):
    """Random places around the robot's start, shape (2, n)."""
    return np.random.default_rng(0).uniform(-reach, reach, (2, n))


def query(scene, seed):
    """Drake's own view of a ground."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 1e-3)
    add_ground(plant, scene, seed)
    plant.Finalize()
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    port = scene_graph.get_query_output_port()
    found = port.Eval(scene_graph.GetMyContextFromRoot(context))
    return found, (diagram, context)  # which own what it looks into


@pytest.mark.parametrize("height", [0.03, -0.03])
def test_ledge_begins_where_it_is_said_to(height):
    ground = Ground(Scene(ledge_height=height, ledge_at=0.8), 0)
    found = ground.height([-15.0, 0.0, 0.799, 0.801, 15.0], [3.0, 0.0, 0.0, 0.0, -3.0])
    assert found == pytest.approx([0.0, 0.0, 0.0, height, height])


@pytest.mark.parametrize(
    "changes", [{"slope": 0.1}, {"step_height": 0.02}, {"ledge_at": 0.0}, {"ledge_at": 20.0}]
)
def test_ledge_that_makes_no_ground_is_refused(changes):
    scenario = Scenario(ground=GroundParameters(**{"ledge_height": 0.03, **changes}))
    with pytest.raises(ScenarioError, match="ledge"):
        scene_of(scenario)


@pytest.mark.parametrize("name", SCENES)
def test_the_height_is_where_drake_has_the_ground(name):
    """A micrometre above it nothing is near, a micrometre below it something is."""
    scene = SCENES[name]
    drake, _owners = query(scene, seed=5)
    x, y = places()
    heights = Ground(scene, 5).height(x, y)
    assert np.isfinite(heights).all()
    for p in np.column_stack([x, y, heights]):
        for above, inside in ((1e-6, False), (-1e-6, True)):
            distances = drake.ComputeSignedDistanceToPoint(p + np.array([0.0, 0.0, above]), 1e-3)
            deepest = min((d.distance for d in distances), default=np.inf)
            assert (deepest < 0.0) == inside, (p, above)


@pytest.mark.parametrize("name", [*SCENES, "stairs"])
def test_the_distance_to_the_ground_is_drakes(name):
    scene = SCENES.get(name, Scene(stairs=StairsParameters(heading=0.2)))
    drake, _owners = query(scene, seed=5)
    random = np.random.default_rng(1)
    points = random.uniform([-1.5, -1.5, -0.3], [2.0, 1.5, 0.9], (200, 3))
    found = Ground(scene, 5).distance(points)
    for p, distance in zip(points, found, strict=True):
        near = drake.ComputeSignedDistanceToPoint(p)
        assert distance == pytest.approx(max(min(d.distance for d in near), 0.0), abs=1e-9)
    assert (found == 0.0).any() and (found > 0.1).any()


def test_the_distance_to_given_patches_counts_from_their_sides():
    square = PatchParameters([[0.0, -0.5], [1.0, -0.5], [1.0, 0.5], [0.0, 0.5]], [0.2, 0.0, 0.0])
    ground = Ground(Scene(patches=[square]))
    points = np.array([[0.5, 0.0, 0.1], [0.5, 0.0, 0.5], [-0.3, 0.0, 0.1], [-0.3, 0.0, 0.6]])
    assert ground.distance(points) == pytest.approx([0.0, 0.3, 0.3, 0.5])


@pytest.mark.parametrize("name", SCENES)
def test_the_pad_is_level(name):
    ground = Ground(SCENES[name], 3)
    x, y = places(reach=EDGE - 1e-6)
    if "rough" not in name and "tiles" not in name:
        x, y = places(reach=1.9)
        x = np.where(x > 0.45, -x, x)  # a slope to the side leans over the edge a little
    np.testing.assert_allclose(ground.height(x, y), 0.0, atol=1e-12)
    assert ground.plane(0.3, 0.4) == 0.0


@pytest.mark.parametrize("heading", np.linspace(-3.0, 3.0, 7))
def test_the_slope_has_its_angle_and_heading(heading):
    ground = Ground(Scene(slope=TEN, slope_heading=heading))
    x, y = np.array([0.6, 1.6, 0.6]), np.array([0.1, 0.1, 1.1])
    z = ground.height(x, y)
    gradient = z[1:] - z[0]
    wanted = np.tan(TEN) * np.array([np.cos(heading), np.sin(heading)])
    np.testing.assert_allclose(gradient, wanted, atol=1e-12)
    np.testing.assert_allclose([ground.plane(*p) for p in zip(x, y, strict=True)], z, atol=1e-12)
    R = slope_axes(TEN, heading)
    np.testing.assert_allclose(R.T @ R, np.eye(3), atol=1e-12)
    assert np.linalg.det(R) == pytest.approx(1.0)
    assert R[0, 1] == 0.0  # the edge of the pad


def test_tiles_are_random_by_the_seed_and_differ_by_the_step_at_most():
    scene = Scene(step_height=0.03)
    x, y = np.meshgrid(np.arange(-7.75, 8.0, 0.5), np.arange(-3.75, 4.0, 0.5))
    heights = Ground(scene, 1).height(x, y)
    assert np.abs(heights).max() <= 0.015
    assert np.abs(heights).max() > 0.0145 and np.unique(heights).size == heights.size - 4 + 1
    assert np.std(heights) == pytest.approx(0.03 / np.sqrt(12.0), rel=0.05)
    np.testing.assert_array_equal(heights, Ground(scene, 1).height(x, y))
    assert (heights != Ground(scene, 2).height(x, y)).mean() > 0.9
    assert Ground(scene, 1).height(9.0, 0.0) == pytest.approx(-0.015)
    assert Ground(scene, 1).height(100.0, 0.0) == -np.inf


def test_a_foot_on_the_slope_feels_its_normal():
    scenario = Scenario(ground=GroundParameters(slope=TEN, slope_heading=0.3))
    loop = build_closed_loop(scenario)
    simulator = loop.make_simulator()
    plant, root = loop.plant.system, simulator.get_mutable_context()
    x = loop.humanoid.x_nominal
    x[4:7] += [2.0, 0.0, loop.ground.plane(2.0, 0.0) + 0.02]
    loop.plant.place(root, x)
    simulator.AdvanceTo(0.05)
    results = plant.get_contact_results_output_port().Eval(plant.GetMyContextFromRoot(root))
    normals = []
    for k in range(results.num_point_pair_contacts()):
        pair = results.point_pair_contact_info(k).point_pair()
        normals.append(np.sign(pair.nhat_BA_W[2]) * pair.nhat_BA_W)
        x, y, z = 0.5 * (pair.p_WCa + pair.p_WCb)
        assert loop.ground.height(x, y) == pytest.approx(z, abs=3e-3)
    assert normals
    np.testing.assert_allclose(normals, np.tile(slope_axes(TEN, 0.3)[:, 2], (len(normals), 1)))


def test_shipped_scenes_are_what_they_are_called():
    assert load_scene("slope_10").slope == pytest.approx(TEN, abs=1e-4)
    assert load_scene("rough").step_height == 0.06
    assert load_scene("slippery").friction == 0.4
    assert load_scene("soft").point_contact_stiffness == 2e4


def test_friction_is_that_of_a_foot_on_the_ground():
    for together in (0.3, 0.4, 1.0, 1.5):
        own = own_friction(together, 0.8)
        assert 2.0 * own * 0.8 / (own + 0.8) == pytest.approx(together)
    assert own_friction(0.8, 0.8) == 0.8
    with pytest.raises(ScenarioError, match=r"friction = 1.6: must be below 1.6, twice the fr"):
        own_friction(1.6, 0.8)


def test_the_closed_loop_has_that_friction():
    loop = build_closed_loop(Scenario(scene="slippery"))
    inspector = loop.GetSubsystemByName("scene_graph").model_inspector()
    found = {
        inspector.GetProximityProperties(geometry)
        .GetProperty("material", "coulomb_friction")
        .dynamic_friction()
        for geometry in inspector.GetAllGeometryIds(Role.kProximity)
    }
    ground, feet = sorted(found)
    assert feet == 0.8
    assert 2.0 * ground * feet / (ground + feet) == pytest.approx(0.4)


def test_a_scenario_has_the_last_word():
    scenario = Scenario(scene="slope_10", seed=4, ground=GroundParameters(slope_heading=np.pi))
    assert ground_of(scenario).plane(1.5, 0.0) == pytest.approx(-np.tan(0.1745))
    assert ground_of(Scenario()).is_flat


@pytest.mark.parametrize("text", ["slope: -0.1", "slope: 1.0", "slope: .nan", "tile: 0.0"])
def test_a_ground_that_is_none_is_refused(tmp_path, text):
    file = tmp_path / "bad.yaml"
    file.write_text(text)
    with pytest.raises(ScenarioError, match=f"{text.split(':')[0]} = "):
        load_scene(str(file))


def test_too_many_tiles_are_refused():
    with pytest.raises(ScenarioError, match=r"ground.tile = 0.1: gives 12800 tiles, which must be"):
        scene_of(Scenario(ground=GroundParameters(step_height=0.01, tile=0.1)), "a.yaml")


@pytest.mark.slow
def test_it_walks_on_soft_ground():
    """As on slopes and tiles: see tests/test_walk_on_uneven_ground.py."""
    segments = [Segment("stand", 0.3), Segment("walk", 3.0, True, [0.4, 0.0])]
    run = simulate(build_closed_loop(Scenario(seed=1, scene="soft", segments=segments)))
    assert not run.fell, run.fall_reason
    assert run.com[-1, 0] > 0.8
    assert np.abs(run.rpy[:, :2]).max() < 0.1
    assert -0.02 < run.contact_points[..., 2].min() < 0.002
