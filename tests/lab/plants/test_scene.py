"""The ground: read from a file, checked, and as slippery and stiff as it says."""

import numpy as np
import pytest
from pydrake.geometry import SceneGraph
from pydrake.multibody.plant import MultibodyPlant

from drake_linefoot.errors import ScenarioError
from drake_linefoot.lab.plants.scene import add_ground
from drake_linefoot.lab.scenario.scene import Scene, load_scene


def test_shipped_scene_has_the_friction_of_the_feet():
    scene = load_scene("flat_ground")
    assert scene.friction == 0.8
    assert scene.point_contact_stiffness > 0.0 and scene.hunt_crossley_dissipation > 0.0


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("friction: 0.0", "friction = 0.0: must be greater than 0"),
        ("friction: .nan", "friction = nan: must be a finite number"),
        ("point_contact_stiffness: -1.0", "point_contact_stiffness = -1.0: must be greater than 0"),
        (
            "hunt_crossley_dissipation: -1.0",
            "hunt_crossley_dissipation = -1.0: must be greater than or equal",
        ),
        ("rgba: [1.0, 1.0]", "rgba = [1.0, 1.0]: must have at least 4 items"),
        ("grip: 0.5", "grip = 0.5: unknown field; must be one of"),
        ("friction: much", "friction = 'much': must be a valid number"),
        ("[1, 2", "is no YAML"),
    ],
)
def test_bad_scene_is_refused_in_one_line(tmp_path, text, said):
    file = tmp_path / "bad.yaml"
    file.write_text(text)
    with pytest.raises(ScenarioError) as caught:
        load_scene(str(file))
    assert str(file) in str(caught.value) and said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_unknown_scene_names_those_there_are():
    with pytest.raises(ScenarioError, match=r"unknown scene; must be one of .*flat_ground"):
        load_scene("moon")


def test_ground_carries_what_the_scene_says():
    plant, scene_graph = MultibodyPlant(0.001), SceneGraph()
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    add_ground(plant, Scene(friction=0.5, point_contact_stiffness=3e5))
    plant.Finalize()
    (ground,) = plant.GetCollisionGeometriesForBody(plant.world_body())
    inspector = scene_graph.model_inspector()
    properties = inspector.GetProximityProperties(ground)
    friction = properties.GetProperty("material", "coulomb_friction")
    assert friction.dynamic_friction() == friction.static_friction() == 0.5
    assert properties.GetProperty("material", "point_contact_stiffness") == 3e5
    assert np.allclose(inspector.GetPoseInFrame(ground).GetAsMatrix4(), np.eye(4))
