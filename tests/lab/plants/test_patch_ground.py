"""Ground of given patches: where it is, and how feet meet it."""

import numpy as np
import pytest
from pydrake.geometry import AddContactMaterial, ProximityProperties, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.framework import DiagramBuilder

from drake_linefoot.errors import ScenarioError
from drake_linefoot.lab.plants.ground import Ground
from drake_linefoot.lab.plants.scene import add_ground
from drake_linefoot.lab.scenario.courses import PatchParameters
from drake_linefoot.lab.scenario.load import make_scenario, validate
from drake_linefoot.lab.scenario.scene import Scene

PAD = PatchParameters(corners=[[-1.0, -1.0], [-1.0, 1.0], [0.5, 1.0], [0.5, -1.0]])
WEDGE = PatchParameters(corners=[[0.5, -1.0], [1.5, 0.0], [0.5, 1.0]], plane=[0.05, 0.1, 0.2])
SCENE = Scene(patches=[PAD, WEDGE])
RADIUS = 0.02


def test_it_is_where_it_is_said_and_nowhere_else():
    ground = Ground(SCENE)
    assert ground.height(0.0, 0.3) == 0.0
    assert ground.height(1.0, 0.2) == pytest.approx(0.05 + 0.1 + 0.04)
    assert ground.height([[0.5, 1.0]], [[0.2, 0.8]]).tolist() == [[pytest.approx(0.14), -np.inf]]
    assert ground.plane(1.5, 0.5) == pytest.approx(0.05 + 0.15 + 0.1)  # of what is nearest
    assert not ground.is_flat
    np.testing.assert_array_equal(ground.patches().sides, [4, 3])


def test_a_sphere_meets_it_at_its_height():
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.001)
    ball = plant.AddRigidBody("ball", SpatialInertia.SolidSphereWithMass(1.0, RADIUS))
    AddContactMaterial(properties=(properties := ProximityProperties()), point_stiffness=1e5)
    plant.RegisterCollisionGeometry(ball, RigidTransform(), Sphere(RADIUS), "ball", properties)
    ground = add_ground(plant, SCENE)
    plant.Finalize()
    context = builder.Build().CreateDefaultContext()
    for x, y in np.random.default_rng(2).uniform([-0.9, -0.3], [1.1, 0.3], (60, 2)):
        if abs(x - 0.5) < 0.03:
            continue
        normal = np.array([0.0, 0.0, 1.0]) if x < 0.5 else np.array([-0.1, -0.2, 1.0])
        normal /= np.linalg.norm(normal)
        touching = np.array([x, y, float(ground.height(x, y))])
        pose = RigidTransform(touching + (RADIUS - 1e-4) * normal)
        plant.SetFreeBodyPose(plant.GetMyMutableContextFromRoot(context), ball, pose)
        asked = scene_graph.get_query_output_port().Eval(scene_graph.GetMyContextFromRoot(context))
        (pair,) = asked.ComputePointPairPenetration()
        assert pair.depth == pytest.approx(1e-4, abs=1e-9)
        np.testing.assert_allclose(np.abs(pair.nhat_BA_W), np.abs(normal), atol=1e-6)


@pytest.mark.parametrize(
    ("ground", "message"),
    [
        ({"patches": []}, "ground.patches = []: must"),
        ({"patches": [{"plane": [0.1, 0.0, 0.0]}]}, "must have one of height 0 where the robot"),
        ({"patches": [{}], "stairs": {}}, "must be none beside another course"),
        ({"patches": [{}, {"corners": [[0, 0], [1, 0]]}]}, "ground.patches[1].corners"),
    ],
)
def test_bad_patches_are_refused_in_a_line(ground, message):
    with pytest.raises(ScenarioError) as caught:
        validate(make_scenario({"ground": ground}, "a.yaml"), "a.yaml")
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)
