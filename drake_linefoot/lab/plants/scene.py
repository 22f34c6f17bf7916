"""The robot and the ground it walks on, in a plant; how they differ from the controller's model."""

import logging
from collections.abc import Iterator

import numpy as np
from pydrake.geometry import (
    AddContactMaterial,
    Box,
    Convex,
    HalfSpace,
    ProximityProperties,
    Role,
    SceneGraph,
    Shape,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import (
    AddMultibodyPlant,
    CoulombFriction,
    MultibodyPlant,
    MultibodyPlantConfig,
)
from pydrake.multibody.tree import RigidBody, SpatialInertia
from pydrake.systems.framework import Context, DiagramBuilder

from drake_linefoot.errors import ScenarioError
from drake_linefoot.lab.plants.ground import Ground
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.scenario.disturbances import ErrorParameters
from drake_linefoot.lab.scenario.scene import Scene, scene_of
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.types import Array

SHADES = (1.0, 0.95, 0.9)  # [-] of the drawn boxes in turn, so that they differ


def _concerns_us(record: logging.LogRecord) -> bool:
    """Return whether it is not Drake's remark on deformable bodies, of which there are none."""
    return "deformable contact" not in record.getMessage()


def ground_of(scenario: Scenario) -> Ground:
    """Return the shape of the ground of a scenario.

    Raises:
        ScenarioError: there is no such scene, or it is not usable.
    """
    return Ground(scene_of(scenario), scenario.seed)


def add_plant(
    builder: DiagramBuilder, humanoid: Humanoid, scenario: Scenario, drawn: bool = True
) -> tuple[MultibodyPlant, SceneGraph, Ground]:
    """Add the robot of a scenario on its ground, finalized.

    The plant's output ports are sampled (Drake's default), which the contact estimator counts
    on: an update that runs after the plant's step sees state and torque of that step.

    Raises:
        ScenarioError: see `ground_of`, `add_ground` and `check_error`.
    """
    config = MultibodyPlantConfig(
        time_step=scenario.plant.time_step,
        contact_model="point",
        discrete_contact_approximation=scenario.plant.contact_approximation,
        stiction_tolerance=scenario.plant.stiction_tolerance,
    )
    plant, scene_graph = AddMultibodyPlant(config, builder)
    humanoid.add_to(plant, drawn)
    ground = add_ground(plant, scene_of(scenario), scenario.seed, scene_graph)
    plant.Finalize()
    check_error(plant, humanoid, scenario.error)
    return plant, scene_graph, ground


def add_ground(
    plant: MultibodyPlant, scene: Scene, seed: int = 0, scene_graph: SceneGraph | None = None
) -> Ground:
    """Add the ground to a plant that is not finalized yet; return its shape.

    Args:
        plant: the robot is already in it.
        scene: what the ground is like.
        seed: of the heights of tiles.
        scene_graph: that of `plant`, which knows the friction of the feet; without, theirs
            counts as equal to the ground's.

    Raises:
        ScenarioError: feet are too slippery for the friction of the scene.
    """
    logging.getLogger("drake").addFilter(_concerns_us)  # added once, however often called
    friction = scene.friction
    if scene_graph is not None:
        friction = own_friction(friction, friction_of_feet(scene_graph, friction))
    properties = ProximityProperties()
    AddContactMaterial(
        dissipation=scene.hunt_crossley_dissipation,
        point_stiffness=scene.point_contact_stiffness,
        friction=CoulombFriction(friction, friction),
        properties=properties,
    )
    world, ground = plant.world_body(), Ground(scene, seed)
    if ground.is_flat:
        plant.RegisterCollisionGeometry(world, RigidTransform(), HalfSpace(), "ground", properties)
        draw_floor(plant, scene)
    for k, (pose, shape) in enumerate(_solids(ground)):
        name = f"ground_{k}"
        plant.RegisterCollisionGeometry(world, pose, shape, name, properties)
        shade = [*(SHADES[k % len(SHADES)] * np.array(scene.rgba[:3])), scene.rgba[3]]
        plant.RegisterVisualGeometry(world, pose, shape, f"{name}_visual", np.array(shade))
    return ground


def _solids(ground: Ground) -> Iterator[tuple[RigidTransform, Shape]]:
    """Yield the boxes or the prisms that ground is made of."""
    for R, p, size in ground.blocks:
        yield RigidTransform(RotationMatrix(R), p), Box(*size)
    for k, corners in enumerate(ground.prisms):
        yield RigidTransform(), Convex(points=corners.T, label=f"patch {k}")


def draw_floor(plant: MultibodyPlant, scene: Scene) -> None:
    """Draw level ground in a plant that is not finalized yet."""
    below = RigidTransform([0.0, 0.0, -0.5 * scene.visual_size[2]])
    world, box = plant.world_body(), Box(*scene.visual_size)
    plant.RegisterVisualGeometry(world, below, box, "ground_visual", np.array(scene.rgba))


def friction_of_feet(scene_graph: SceneGraph, otherwise: float) -> float:
    """Return the friction of what is in a scene graph; the largest, when it differs."""
    inspector = scene_graph.model_inspector()
    found = [
        inspector.GetProximityProperties(geometry)
        .GetPropertyOrDefault("material", "coulomb_friction", CoulombFriction(otherwise, otherwise))
        .dynamic_friction()
        for geometry in inspector.GetAllGeometryIds(Role.kProximity)
    ]
    return float(max(found, default=otherwise))


def own_friction(together: float, feet: float) -> float:
    """Return the ground's friction that gives `together` with that of the feet.

    Drake combines the two sides m1 and m2 of a contact to 2 m1 m2 / (m1 + m2).

    Raises:
        ScenarioError: no friction of the ground does.
    """
    if together == feet:
        return together
    if together >= 2.0 * feet:
        allowed = f"must be below {2.0 * feet:g}, twice the friction of the feet"
        raise ScenarioError("scene", "friction", together, allowed)
    return together * feet / (2.0 * feet - together)


def check_error(plant: MultibodyPlant, humanoid: Humanoid, error: ErrorParameters) -> None:
    """Check that the torso keeps a mass.

    Raises:
        ScenarioError: it does not.
    """
    mass = humanoid.names_in(plant).body(humanoid.torso.name()).default_mass()
    if mass + error.torso_mass <= 0.0:
        allowed = f"must be above -{mass:g} kg, the mass of the torso"
        raise ScenarioError("scenario", "error.torso_mass", error.torso_mass, allowed)


def apply_error(
    plant: MultibodyPlant, context: Context, humanoid: Humanoid, error: ErrorParameters
) -> None:
    """Give a plant's context masses, inertias and damping that differ from the model's.

    A body's inertia about its centre of mass grows with its mass; a centre of mass that is
    moved takes it along.

    The Coulomb friction of an error is the business of the actuators.
    """
    torso = humanoid.names_in(plant).body(humanoid.torso.name())
    share = 1.0 + error.torso_mass / torso.default_mass()
    X_TB = humanoid.base.body_frame().CalcPose(humanoid.scratch, humanoid.torso.body_frame())
    R_TB = X_TB.rotation()
    _set_inertia(torso, context, share, R_TB @ np.array(error.torso_com))
    for body in leg_bodies(plant, humanoid):
        _set_inertia(body, context, error.leg_mass_scale, np.zeros(3))
    for name in humanoid.description.actuated_joints:
        joint = humanoid.names_in(plant).joint(name)
        joint.SetDampingVector(context, joint.default_damping_vector() + error.joint_damping)


def leg_bodies(plant: MultibodyPlant, humanoid: Humanoid) -> list[RigidBody]:
    """Return the bodies that the leg joints of the description move, both legs."""
    names = [name for foot in humanoid.description.feet for name in foot.leg_joints]
    joints = [humanoid.names_in(plant).joint(name).index() for name in names]
    return [plant.get_body(index) for index in plant.GetBodiesKinematicallyAffectedBy(joints)]


def _set_inertia(body: RigidBody, context: Context, share: float, offset: Array) -> None:
    """Scale the mass of a body about its centre of mass, and move that by `offset` [m]."""
    nominal = body.default_spatial_inertia()
    if nominal.get_mass() == 0.0:
        return
    p, mass = nominal.get_com(), nominal.get_mass()
    about_com = nominal.CalcRotationalInertia().ShiftToCenterOfMass(mass, p)
    inertia = SpatialInertia.MakeFromCentralInertia(share * mass, p + offset, share * about_com)
    body.SetSpatialInertiaInBodyFrame(context, inertia)
