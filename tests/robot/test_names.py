"""A robot beside others whose parts have the same names, in one plant."""

import pytest
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, MultibodyPlant
from pydrake.systems.framework import DiagramBuilder

from drake_linefoot.errors import ModelError
from drake_linefoot.lab.new_robot.analysis import analyse
from drake_linefoot.lab.plants.contact_forces import ContactForces
from drake_linefoot.lab.plants.scene import apply_error, check_error, leg_bodies
from drake_linefoot.lab.scenario.disturbances import ErrorParameters
from drake_linefoot.robot.humanoid import load_humanoid
from tests.helpers import made_up_robots as made_up
from tests.helpers.other_formats import as_sdf

BODIES = ("torso", "left_foot_link", "right_foot_link", "linefoot_base")
PROP = (
    """<sdf version="1.7"><model name="prop">"""
    + "".join(
        f"""<link name="{name}"><pose>{i} 9 0 0 0 0</pose>
        <inertial><mass>1</mass></inertial></link>"""
        for i, name in enumerate(BODIES)
    )
    + """<joint name="left_knee" type="revolute"><parent>torso</parent><child>left_foot_link</child>
    <axis><xyz>0 1 0</xyz></axis></joint></model></sdf>"""
)


@pytest.mark.parametrize("first", [True, False])
def test_a_prop_may_share_names_with_the_robot(first):
    plant, humanoid = MultibodyPlant(1e-3), load_humanoid("mit_humanoid")
    if first:
        Parser(plant).AddModelsFromString(PROP, "sdf")
    humanoid.add_to(plant)
    if not first:
        Parser(plant).AddModelsFromString(PROP, "sdf")
    plant.Finalize()
    names, own = humanoid.names_in(plant), humanoid.plant
    assert plant.num_actuators(names.root) == humanoid.na
    assert names.joint("left_knee").model_instance() == names.root
    assert names.body("torso").default_mass() == own.GetBodyByName("torso").default_mass()
    assert {body.model_instance() for body in leg_bodies(plant, humanoid)} == {names.root}
    ContactForces(humanoid, plant)
    error = ErrorParameters(torso_mass=1.0, leg_mass_scale=1.1)
    check_error(plant, humanoid, error)
    context = plant.CreateDefaultContext()
    before = plant.CalcTotalMass(context, [names.root])
    apply_error(plant, context, humanoid, error)
    assert plant.CalcTotalMass(context, [names.root]) > before + 1.0


def test_two_robots_of_a_kind_share_a_plant():
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, 1e-3)
    robots = [load_humanoid("mit_humanoid") for _ in range(3)]
    robots[0].add_to(plant)
    robots[1].add_to(plant)
    robots[2].add_to(plant, name="third")
    plant.Finalize()
    roots = [robot.names_in(plant).root for robot in robots]
    assert len(set(roots)) == 3
    assert plant.GetModelInstanceName(roots[2]) == "third"
    context, x = plant.CreateDefaultContext(), robots[0].x_nominal
    for i, (robot, root) in enumerate(zip(robots, roots, strict=True)):
        x[5] = i
        plant.SetPositionsAndVelocities(context, root, x)
        assert plant.get_state_output_port(root).size() == len(x)
        torso = robot.names_in(plant).body("torso")
        assert torso.EvalPoseInWorld(context).translation()[1] == pytest.approx(i)
        assert plant.CalcTotalMass(context, [root]) == pytest.approx(robot.mass)


def test_a_name_that_is_taken_is_refused():
    plant = MultibodyPlant(1e-3)
    robots = [load_humanoid("mit_humanoid") for _ in range(2)]
    robots[0].add_to(plant, name="walker")
    with pytest.raises(ModelError, match="walker"):
        robots[1].add_to(plant, name="walker")


def test_a_name_has_a_scope_where_models_of_one_file_share_it(tmp_path):
    """A static model beside the robot has its names, too."""
    text = as_sdf(made_up.mit())
    shed = (
        """<model name="shed"><static>true</static><link name="torso"><inertial><mass>50</mass>"""
        """</inertial></link><link name="left_foot_link"/></model>"""
    )
    text = text.replace("<model", f"<world name='w'>{shed}<model", 1)
    text = text.replace("</sdf>", "</world></sdf>")
    file = tmp_path / "world.sdf"
    file.write_text(text, encoding="utf-8")
    found = analyse(file)
    plain = tmp_path / "alone.sdf"
    plain.write_text(as_sdf(made_up.mit()), encoding="utf-8")
    alone = analyse(plain)
    assert found.humanoid.mass == pytest.approx(alone.humanoid.mass)
    assert found.data["nominal_posture"] == alone.data["nominal_posture"]
    names = found.humanoid.names
    assert names.name_of(names.body("torso")) == found.data["floating_base"] == "torso"
    assert names.body("shed::torso").default_mass() == pytest.approx(50.0)
    assert names.has_joint("biped::left_knee") and not names.has_joint("shed::left_knee")
