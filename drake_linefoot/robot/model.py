"""A robot in a plant: parsed, joints locked, with frames, actuators and feet as described.

What Drake says of a model that it does not take becomes one error of one line.
"""

import logging
import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from pydrake.common.eigen_geometry import AngleAxis
from pydrake.geometry import AddContactMaterial, ProximityProperties, Sphere
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    ModelInstanceIndex,
    PrismaticJoint,
    QuaternionFloatingJoint,
    RevoluteJoint,
    SpatialInertia,
    WeldJoint,
)

from drake_linefoot.axes import points_of_foot
from drake_linefoot.errors import MissingPackageError, ModelError, legible
from drake_linefoot.resources import models_dir
from drake_linefoot.robot.description import (
    LINE,
    FootDescription,
    HumanoidDescription,
    PoseDescription,
)
from drake_linefoot.robot.model_file import SPEED, ModelFile
from drake_linefoot.robot.model_inertia import without_drakes
from drake_linefoot.robot.names import Names

BASE, CONTACT = "linefoot_base", "linefoot_{}_foot"  # frames that a description adds
FRICTION = 0.8  # of the spheres of the feet, as of the scenes
STIFFNESS, DISSIPATION = 5.0e5, 20.0  # [N/m], [s/m] at each end of a foot of a robot of `MASS`
MASS = 25.0  # [kg]
RADIUS_SHARE = 1.0 / 15.0  # [-] radius of the spheres by the length of the line
ENDLESS = 1e15  # [rad] of a limit that is none; Gazebo writes 1e16
SLACK = 1e-4  # [rad, m] by which an angle may be beyond a limit that was rounded
MOST_NAMED = 6  # names in a line
_PLACE = re.compile(r"^(?:\S*/|<literal-string>\.)\S*?(?::\d+)?: ")  # file and line


def pose_of(pose: PoseDescription | None) -> RigidTransform:
    """Return a pose of the description."""
    if pose is None:
        return RigidTransform()
    return RigidTransform(RollPitchYaw(pose.rpy), pose.xyz)


def add_model(
    plant: MultibodyPlant,
    description: HumanoidDescription,
    model: ModelFile,
    drawn: bool,
    name: str | None = None,
) -> tuple[Names, list[str]]:
    """Add a robot to a plant that is not finalized; its model instance gets a name, if given.

    Of the collision shapes only those of feet stay that touch along a line, where they are a sphere
    at heel and toe. Other feet get such spheres, soles one at each corner, since Drake makes one
    contact point of each pair of shapes, which in a box or a mesh jumps between its ends.

    Returns:
        Where its parts are, and what was done, a line each.

    Raises:
        ModelError: the model cannot be parsed, the name is taken, or it does not have what is
            described.
    """
    d, feet = description, {foot.frame for foot in description.feet}
    is_kept = d.contact == LINE and feet <= model.line_feet
    keep = feet if is_kept else set()
    with parser_errors(d.file, "model", str(d.model)), drake_warnings() as notes:
        text = model.text(keep, drawn and plant.geometry_source_is_registered())
        instances, bounded = parse(plant, model, text)
        names = Names(plant, instances, d.floating_base)
        if name is not None:
            plant.RenameModelInstance(names.root, name)
        _free_base(names, d)
        for joint, angle in d.lock.items():
            _lock(names, d, str(joint), angle)
        lines = _add_actuators(names, model)
        for i, foot in enumerate(d.feet):
            if not names.has_frame(foot.frame):
                raise d.refuse(f"feet[{i}].frame", foot.frame, "no such frame in the model")
            frame = names.frame(foot.frame)
            if foot.pose is not None:
                X = frame.GetFixedPoseInBodyFrame() @ pose_of(foot.pose)
                body = frame.body().body_frame()
                plant.AddFrame(FixedOffsetFrame(CONTACT.format(foot.name), body, X))
        mimics = [name for name in model.mimics if name not in d.lock]
        if mimics:
            allowed = f"{mimics[0]} follows another joint: must be locked"
            raise d.refuse("lock", list(d.lock), allowed)
        if not keep:
            lines += _give_spheres(names, d, model)
    if bounded:
        lines.append(f"{bounded} joints: continuous, bounded by half a turn either way")
    if d.lock:
        lines.append(f"{len(d.lock)} joints locked: {_listed(d.lock)}")
    drakes = [f"Drake: {note}" for note in without_drakes(notes, model.notes)]
    return names, [*model.notes, *drakes, *lines]


def foot_frame_name(foot: FootDescription) -> str:
    """Return the name of the frame F of a foot in a plant of `add_model`."""
    return foot.frame if foot.pose is None else CONTACT.format(foot.name)


def base_name(description: HumanoidDescription) -> str:
    """Return the name of the body B in a plant of `add_model`."""
    return description.floating_base if description.floating_base_pose is None else BASE


def parse(
    plant: MultibodyPlant, model: ModelFile, text: str | None
) -> tuple[list[ModelInstanceIndex], int]:
    """Add a file to a plant: XML that a method of `model` gave, or what it leaves to Drake.

    Returns:
        The models that it has made, those inside others, too; and how many joints that turn
        without end were bounded by half a turn either way.
    """
    parser, before = Parser(plant), plant.num_model_instances()
    parser.SetAutoRenaming(True)
    parser.package_map().AddPackageXml(str(models_dir() / "package.xml"))
    if text is None:
        parser.AddModels(str(model.path))
    else:
        parser.AddModelsFromString(text, model.path.suffix[1:].lower())
    instances = [ModelInstanceIndex(i) for i in range(before, plant.num_model_instances())]
    bounded = 0
    for joint in (plant.get_joint(index) for index in plant.GetJointIndices()):
        if joint.model_instance() not in instances or not isinstance(joint, RevoluteJoint):
            continue
        if model.knows_no_speeds and np.isinf(joint.velocity_upper_limits()[0]):
            joint.set_velocity_limits([-SPEED], [SPEED])
        low, high = joint.position_lower_limits(), joint.position_upper_limits()
        if model.may_turn_without_end and not np.abs([*low, *high]).max() < ENDLESS:
            at = joint.default_positions()
            joint.set_default_positions([0.0])  # Drake wants it within the limits
            joint.set_position_limits(np.maximum(low, -np.pi), np.minimum(high, np.pi))
            joint.set_default_positions(np.clip(at, -np.pi, np.pi))
            bounded += 1
    return instances, bounded


def _free_base(names: Names, d: HumanoidDescription) -> None:
    """Let the torso float, under a massless body with the axes of B where it has others."""
    plant, name = names.plant, d.floating_base
    if not names.has_body(name):
        raise d.refuse("floating_base", name, "no such body in the model")
    torso = names.body(name)
    if d.floating_base_pose is None:
        return
    for joint in names.joints():
        if joint.child_body().index() == torso.index():
            if not isinstance(joint, QuaternionFloatingJoint):
                raise d.refuse("floating_base", name, "is not a floating body")
            plant.RemoveJoint(joint)
    base = plant.AddRigidBody(BASE, torso.model_instance(), SpatialInertia.Zero())
    X_TB = pose_of(d.floating_base_pose)
    plant.WeldFrames(base.body_frame(), torso.body_frame(), X_TB.inverse())


def _lock(names: Names, d: HumanoidDescription, name: str, angle: float) -> None:
    """Make a joint a weld."""
    plant, entry = names.plant, f"lock.{name}"
    if not names.has_joint(name):
        raise d.refuse(entry, name, "no such joint in the model")
    joint = names.joint(name)
    if isinstance(joint, RevoluteJoint):
        X = RigidTransform(RotationMatrix(AngleAxis(angle, joint.revolute_axis())), np.zeros(3))
    elif isinstance(joint, PrismaticJoint):
        X = RigidTransform(angle * joint.translation_axis())
    else:
        raise d.refuse(entry, angle, "must be a revolute or a prismatic joint")
    low, high = joint.position_lower_limits()[0], joint.position_upper_limits()[0]
    if not low - SLACK <= angle <= high + SLACK:
        raise d.refuse(entry, angle, f"must lie in [{low:g}, {high:g}]")
    for index in plant.GetJointActuatorIndices():
        actuator = plant.get_joint_actuator(index)
        if actuator.joint().index() == joint.index():
            plant.RemoveJointActuator(actuator)
    joint_name, parent, child = joint.name(), joint.frame_on_parent(), joint.frame_on_child()
    plant.RemoveJoint(joint)
    plant.AddJoint(WeldJoint(joint_name, parent, child, X))


def _add_actuators(names: Names, model: ModelFile) -> list[str]:
    """Give the moving joints that have none an actuator of the effort that the file says."""
    plant = names.plant
    have = {plant.get_joint_actuator(i).joint().index() for i in plant.GetJointActuatorIndices()}
    made = 0
    for joint in names.joints():
        effort = model.efforts.get(joint.name(), 0.0)
        one = isinstance(joint, RevoluteJoint | PrismaticJoint)
        if one and joint.index() not in have and effort > 0:
            plant.AddJointActuator(joint.name(), joint, effort)
            made += 1
    return [f"{made} actuators made from effort limits, for want of a transmission"] * bool(made)


def _give_spheres(names: Names, d: HumanoidDescription, model: ModelFile) -> list[str]:
    """Put a sphere to heel and toe of each foot, or to each corner of its sole."""
    plant = names.plant
    bodies = [plant.get_body(i) for each in names.instances for i in plant.GetBodyIndices(each)]
    fixed = {body.index() for body in plant.GetBodiesWeldedTo(plant.world_body())}
    bodies = [body for body in bodies if body.index() not in fixed]
    share = sum(body.default_mass() for body in bodies) / MASS
    properties = ProximityProperties()
    AddContactMaterial(
        dissipation=DISSIPATION,
        point_stiffness=STIFFNESS * share * 2.0 / len(d.feet[0].ground_points),
        friction=CoulombFriction(FRICTION, FRICTION),
        properties=properties,
    )
    heel, toe = d.feet[0].contact_points
    radius = RADIUS_SHARE * float(toe[0] - heel[0])
    if plant.geometry_source_is_registered():
        for foot in d.feet:
            frame = names.frame(foot_frame_name(foot))
            X_BF = frame.GetFixedPoseInBodyFrame()
            points = foot.ground_points
            for name, point in zip(points_of_foot(len(points)), points, strict=True):
                X = RigidTransform(X_BF @ (point + np.array([0.0, 0.0, radius])))
                label = f"{foot.name}_{name}"
                plant.RegisterCollisionGeometry(frame.body(), X, Sphere(radius), label, properties)
    had = f"{model.shapes} collision shapes left out: " if model.shapes else ""
    where = "heel and toe" if d.contact == LINE else "the corners of their soles"
    return [f"{had}feet touch the ground with spheres of {radius:.3f} m at {where}"]


def _listed(names: Iterable[object]) -> str:
    """Return some names, the first few of them."""
    first = [str(name) for name in names]
    return ", ".join(first[:MOST_NAMED]) + ", ..." * (len(first) > MOST_NAMED)


def shortened(text: object) -> str:
    """Return a message on one line and of limited length, without the file that Drake names."""
    return legible(_PLACE.sub("", " ".join(str(text).split())).removeprefix("error: "))


@contextmanager
def parser_errors(file: Path, entry: str, value: object) -> Iterator[None]:
    """Raise whatever Drake throws inside the `with` block as a ModelError of a description.

    Drake's own conditions end as SystemExit, which no `except Exception` catches.
    """
    try:
        yield
    except (MissingPackageError, ModelError):
        raise
    except (Exception, SystemExit) as error:
        raise ModelError(file, entry, value, f"Drake refuses it: {shortened(error)}") from error


@contextmanager
def drake_warnings() -> Iterator[list[str]]:
    """Collect Drake's warnings, which are not shown meanwhile."""
    found: list[str] = []

    class Collect(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            found.append(shortened(record.getMessage()).removeprefix("warning: "))

    logger, handler = logging.getLogger("drake"), Collect(logging.WARNING)
    level, shown = logger.level, logger.propagate
    logger.addHandler(handler)
    logger.setLevel(logging.WARNING)
    logger.propagate = False
    try:
        yield found
    finally:
        logger.removeHandler(handler)
        logger.setLevel(level)
        logger.propagate = shown
