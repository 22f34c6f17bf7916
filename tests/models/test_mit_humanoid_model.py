"""The MIT Humanoid's model: Drake reads it cleanly and finds the robot's published figures."""

import io
import logging

import numpy as np
import pytest
import yaml
from pydrake.geometry import AddContactMaterial, HalfSpace, ProximityProperties, Role, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import (
    AddMultibodyPlant,
    CoulombFriction,
    MultibodyPlantConfig,
)
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from drake_linefoot.resources import models_dir

ROBOT = models_dir() / "mit_humanoid"
URDF = ROBOT / "mit_humanoid.urdf"
SIDES = ("left", "right")
# Per joint of a left limb: lower, upper [rad], velocity [rad/s], effort [N m], reflected inertia
# [kg m^2], factor on the angle of the right twin. Written down here apart from the model's table.
FACTS = {
    "hip_yaw": (-1.0, 1.0, 48.0, 34.0, 0.00606276, -1),
    "hip_abad": (-1.2, 1.2, 48.0, 34.0, 0.00606276, -1),
    "hip_pitch": (-1.5, 1.5, 40.0, 72.0, 0.0199728, 1),
    "knee": (0.0, 2.2, 20.0, 144.0, 0.0798912, 1),
    "ankle": (-0.8, 0.8, 24.0, 68.0, 0.02425104, 1),
    "shoulder_pitch": (-3.14, 3.14, 48.0, 34.0, 0.00606276, 1),
    "shoulder_abad": (-0.1, 3.14, 48.0, 34.0, 0.00606276, -1),
    "shoulder_yaw": (-3.14, 3.14, 48.0, 34.0, 0.00606276, -1),
    "elbow": (-2.3, 1.7, 30.0, 55.0, 0.01364121, 1),
}
NAMES = [f"{side}_{joint}" for side in SIDES for joint in FACTS]
LEG_LINKS = ("hip_yaw", "hip_abad", "thigh", "shank", "foot")
# Hip pitch, knee, ankle; base height; CoM x, z; CoM x past the middle of the contact lines;
# composite ixx, iyy, izz, ixz about the CoM. Torso upright, x from the torso, z from the ground.
POSTURES = {
    "nominal": (
        (-0.634782, 1.3, -0.665218),
        0.63586,
        (0.0240, 0.6006, 0.0000),
        (1.5635, 1.1715, 0.5516, 0.1060),
    ),
    "nominal_tall": (
        (-0.42385, 0.9, -0.47615),
        0.69265,
        (0.0197, 0.6523, 0.0000),
        (1.6639, 1.2524, 0.5322, 0.0805),
    ),
    "mit_mpc_legs": (
        (-0.724757, 1.412282, -0.68752),
        0.61687,
        (0.0261, 0.5839, -0.0118),
        (1.5242, 1.1414, 0.5609, 0.1191),
    ),
    "fld_default": (
        (-0.4, 0.9, -0.45),
        0.69703,
        (0.0188, 0.6563, 0.0128),
        (1.6683, 1.2549, 0.5302, 0.0708),
    ),
    "straight": (
        (0.0, 0.0, 0.0),
        0.74725,
        (0.0106, 0.7016, -0.0270),
        (1.7684, 1.3343, 0.5096, 0.0186),
    ),
}


class Model:
    """The robot alone in a diagram, with its contexts."""

    def __init__(self, ground=None):
        builder = DiagramBuilder()
        config = MultibodyPlantConfig(time_step=1e-3, contact_model="point")
        self.plant, self.scene_graph = AddMultibodyPlant(config, builder)
        parser = Parser(self.plant)
        parser.SetStrictParsing()
        (self.robot,) = parser.AddModels(str(URDF))
        if ground is not None:
            pose = RigidTransform()
            self.plant.RegisterCollisionGeometry(
                self.plant.world_body(), pose, HalfSpace(), "ground", ground
            )
        self.plant.Finalize()
        self.diagram = builder.Build()
        self.root = self.diagram.CreateDefaultContext()
        self.context = self.plant.GetMyMutableContextFromRoot(self.root)

    def set_legs(self, hip_pitch, knee, ankle):
        """Upright torso, both legs bent, its lowest foot point on z = 0; returns the height."""
        self.plant.SetPositions(self.context, np.eye(25)[0])
        for side in SIDES:
            for name, angle in (("hip_pitch", hip_pitch), ("knee", knee), ("ankle", ankle)):
                self.plant.GetJointByName(f"{side}_{name}").set_angle(self.context, angle)
        height = -self.foot_points().min(axis=1)[2]
        positions = self.plant.GetPositions(self.context)
        positions[6] = height
        self.plant.SetPositions(self.context, positions)
        return height

    def foot_points(self):
        """Heel and toe of the left foot in the world frame, shape (3, 2)."""
        frame = self.plant.GetFrameByName("left_foot_link")
        points = np.array([[-0.05, 0.0, -0.041], [0.1, 0.0, -0.041]]).T
        return self.plant.CalcPointsPositions(self.context, frame, points, self.plant.world_frame())

    def inspect(self, role):
        """The geometry ids of one role with their inspector."""
        inspector = self.scene_graph.model_inspector()
        return inspector, inspector.GetAllGeometryIds(role)


@pytest.fixture(scope="module")
def model():
    return Model()


def test_drake_reads_the_model_strictly_and_without_a_word():
    said = io.StringIO()
    handler = logging.StreamHandler(said)
    logger = logging.getLogger("drake")
    logger.addHandler(handler)
    try:
        logger.warning("heard")
        Model()
    finally:
        logger.removeHandler(handler)
    assert said.getvalue() == "heard\n"


def test_sizes_and_order(model):
    plant = model.plant
    assert (plant.num_positions(), plant.num_velocities()) == (25, 24)
    assert plant.num_actuators() == plant.num_actuated_dofs() == 18
    assert plant.GetUniqueFloatingBaseBodyOrThrow(model.robot).name() == "torso"
    assert plant.GetActuatorNames(add_model_instance_prefix=False) == NAMES
    velocities = plant.GetVelocityNames(add_model_instance_prefix=False)
    assert velocities[6:] == [f"{name}_w" for name in NAMES]
    np.testing.assert_array_equal(plant.MakeActuationMatrix(), np.eye(24)[:, 6:])


def test_masses(model):
    plant = model.plant
    assert plant.CalcTotalMass(model.context) == pytest.approx(24.86855, abs=1e-9)
    for side in SIDES:
        leg = sum(plant.GetBodyByName(f"{side}_{name}_link").default_mass() for name in LEG_LINKS)
        assert leg == pytest.approx(5.330541, abs=1e-9)
    assert 2 * leg / plant.CalcTotalMass(model.context) == pytest.approx(0.4287, abs=5e-5)


@pytest.mark.parametrize("name", POSTURES)
def test_published_postures(model, name):
    angles, base_height, (x, z, past_middle), inertia = POSTURES[name]
    plant = model.plant
    assert model.set_legs(*angles) == pytest.approx(base_height, abs=6e-6)
    com = plant.CalcCenterOfMassPositionInWorld(model.context)
    middle = model.foot_points().mean(axis=1)
    expected = [x, 0.0, z, past_middle]
    np.testing.assert_allclose([*com, com[0] - middle[0]], expected, atol=6e-5, rtol=0)
    assert abs(com[1]) < 1e-15

    bodies = plant.GetBodyIndices(model.robot)
    spatial = plant.CalcSpatialInertia(model.context, plant.world_frame(), bodies)
    about_com = spatial.Shift(com).CalcRotationalInertia().CopyToFullMatrix3()
    found = [*np.diag(about_com), about_com[0, 2]]
    np.testing.assert_allclose(found, inertia, atol=6e-5, rtol=0)
    np.testing.assert_allclose(about_com[[0, 1], [1, 2]], 0.0, atol=1e-14)


def test_every_link_is_a_possible_body(model):
    margins = {}
    for index in model.plant.GetBodyIndices(model.robot):
        body = model.plant.get_body(index)
        spatial = body.default_spatial_inertia()
        mass, r = spatial.get_mass(), spatial.get_com()
        about_origin = spatial.CalcRotationalInertia().CopyToFullMatrix3()
        about_com = about_origin - mass * (r @ r * np.eye(3) - np.outer(r, r))
        moments = np.linalg.eigvalsh(about_com)
        assert mass > 0 and moments[0] > 0, body.name()
        margins[body.name()] = (moments[0] + moments[1] - moments[2]) / moments.sum()
    assert len(margins) == 19
    assert min(margins.values()) == pytest.approx(0.0047, abs=5e-5)
    assert min(margins, key=margins.get) in {"left_forearm_link", "right_forearm_link"}


def mirror_of_joints():
    """The signed permutation that turns joint angles or rates into those of the mirror image."""
    signs = np.array([facts[-1] for facts in FACTS.values()], dtype=float)
    zero = np.zeros((9, 9))
    return np.block([[zero, np.diag(signs)], [np.diag(signs), zero]])


def test_mirrored_states_have_mirrored_mass_matrices(model):
    joints = mirror_of_joints()
    twist = np.diag([-1.0, 1.0, -1.0, 1.0, -1.0, 1.0])
    velocity = np.block([[twist, np.zeros((6, 18))], [np.zeros((18, 6)), joints]])
    rng = np.random.default_rng(7)
    for _ in range(5):
        q = rng.uniform(-1.0, 1.0, 25)
        q[:4] /= np.linalg.norm(q[:4])
        mirrored = np.concatenate([q[:7] * [1, -1, 1, -1, 1, -1, 1], joints @ q[7:]])
        model.plant.SetPositions(model.context, q)
        mass = model.plant.CalcMassMatrix(model.context)
        model.plant.SetPositions(model.context, mirrored)
        image = model.plant.CalcMassMatrix(model.context)
        np.testing.assert_allclose(image, velocity @ mass @ velocity.T, atol=1e-12, rtol=0)


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("name", FACTS)
def test_joint_limits(model, side, name):
    lower, upper, velocity, effort, _, sign = FACTS[name]
    if side == "right" and sign < 0:
        lower, upper = -upper, -lower
    joint = model.plant.GetJointByName(f"{side}_{name}")
    actuator = model.plant.GetJointActuatorByName(f"{side}_{name}")
    assert (joint.position_lower_limit(), joint.position_upper_limit()) == (lower, upper)
    assert joint.velocity_upper_limit() == -joint.velocity_lower_limit() == velocity
    assert actuator.effort_limit() == effort
    assert joint.default_damping() == 0.0


def test_rotors_add_their_reflected_inertia_and_nothing_else(model):
    plant = model.plant
    bare = plant.CreateDefaultContext()
    for name in NAMES:
        plant.GetJointActuatorByName(name).SetRotorInertia(bare, 0.0)
    plant.SetPositions(bare, plant.GetPositions(model.context))
    added = plant.CalcMassMatrix(model.context) - plant.CalcMassMatrix(bare)
    reflected = [facts[4] for facts in FACTS.values()]
    expected = np.diag([*np.zeros(6), *reflected, *reflected])
    np.testing.assert_allclose(added, expected, atol=1e-9, rtol=0)


def test_only_heel_and_toe_collide(model):
    inspector, ids = model.inspect(Role.kProximity)
    found = set()
    for geometry in ids:
        shape = inspector.GetShape(geometry)
        assert isinstance(shape, Sphere)
        assert shape.radius() == 0.01
        body = inspector.GetName(inspector.GetFrameId(geometry)).split("::")[-1]
        centre = inspector.GetPoseInFrame(geometry).translation()
        found.add((body, *centre.round(12)))
        properties = inspector.GetProximityProperties(geometry)
        friction = properties.GetProperty("material", "coulomb_friction")
        assert friction.dynamic_friction() == friction.static_friction() == 0.8
        assert properties.GetProperty("material", "point_contact_stiffness") == 5e5
        assert properties.GetProperty("material", "hunt_crossley_dissipation") == 20.0
    feet = ("left_foot_link", "right_foot_link")
    assert found == {(foot, x, 0.0, -0.031) for foot in feet for x in (-0.05, 0.1)}
    assert len(ids) == 4


def test_locked_robot_stands_on_four_points():
    data = yaml.safe_load((ROBOT.parent / "scenes" / "flat_ground.yaml").read_text("utf-8"))
    assert set(data) == {
        *("friction", "point_contact_stiffness", "hunt_crossley_dissipation"),
        *("visual_size", "rgba"),
    }
    ground = ProximityProperties()
    AddContactMaterial(
        dissipation=data["hunt_crossley_dissipation"],
        point_stiffness=data["point_contact_stiffness"],
        friction=CoulombFriction(data["friction"], data["friction"]),
        properties=ground,
    )
    model = Model(ground)
    model.set_legs(*POSTURES["nominal"][0])
    for name in NAMES:
        model.plant.GetJointByName(name).Lock(model.context)
    simulator = Simulator(model.diagram, model.root)
    simulator.AdvanceTo(0.5)
    results = model.plant.get_contact_results_output_port().Eval(model.context)
    contacts = [
        results.point_pair_contact_info(i) for i in range(results.num_point_pair_contacts())
    ]
    assert len(contacts) == 4
    force = sum(abs(contact.contact_force()[2]) for contact in contacts)
    assert force == pytest.approx(24.86855 * 9.81, rel=0.01)
    for contact in contacts:  # two springs of 5e5 N/m in series
        assert contact.point_pair().depth == pytest.approx(force / 4 / 2.5e5, rel=0.05)
