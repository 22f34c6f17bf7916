"""A model with all its joints, as its file has it."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pydrake.geometry import SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Frame, Joint, ModelInstanceIndex, RigidBody
from pydrake.systems.framework import Context

from drake_linefoot.errors import ModelError
from drake_linefoot.robot.floating_tree import FloatingTree
from drake_linefoot.robot.model_file import ModelFile, read_model_file
from drake_linefoot.robot.names import Names
from drake_linefoot.robot.shapes import drawn_plant
from drake_linefoot.types import Array


@dataclass(frozen=True)
class Skeleton:
    """A model with all its joints, at angles 0 or the nearest that the limits allow.

    Attributes:
        model: the file.
        plant: the robot, finalized, with what feet are made of as drawings.
        scene_graph: of these.
        context: of `plant`, floating base at the origin.
        names: of its joints and bodies.
        com: of the robot in its root [m], shape (3,), so that nothing hangs on where the root's
            frame is.
        root: the floating body.
        joints: those that move, with one degree of freedom.
    """

    model: ModelFile
    plant: MultibodyPlant
    scene_graph: SceneGraph
    context: Context
    names: Names
    com: Array
    root: RigidBody
    joints: list[Joint]

    def refuse(self, value: object, reason: str) -> ModelError:
        """Return the error of a robot that cannot be taken."""
        return ModelError(self.model.path, "robot", value, reason)

    def chain(self, body: RigidBody) -> list[Joint]:
        """Return the joints from the root to a body."""
        joints: list[Joint] = []
        inner = {
            other.index(): joint
            for joint in self.joints
            for other in self.plant.GetBodiesWeldedTo(joint.child_body())
        }
        at = body
        while at.index() in inner:
            joints.insert(0, inner[at.index()])
            at = joints[0].parent_body()
        return joints

    def efforts(self) -> dict[str, float]:
        """Return limits of torque by the names of joints, of those that have one [N m]."""
        motors = map(self.plant.get_joint_actuator, self.plant.GetJointActuatorIndices())
        of_motors = {self.names.name_of(m.joint()): float(m.effort_limit()) for m in motors}
        return self.model.efforts | of_motors

    def place(self, frame: Frame) -> Array:
        """Return where the origin of a frame is in the root [m], shape (3,)."""
        return frame.CalcPose(self.context, self.root.body_frame()).translation()


def read_skeleton(path: Path) -> Skeleton:
    """Read a model and put all its joints where they are at rest.

    Raises:
        ModelError: it cannot be read, or it is not one robot with a floating base.
    """
    model = read_model_file(path, path)
    plant, scene_graph = drawn_plant(model, path)
    bases = [plant.get_body(index) for index in plant.GetFloatingBaseBodies()]
    if len(bases) != 1:
        found = [base.name() for base in bases]
        why = "there are more" if bases else "is it welded to the world?"
        allowed = f"must have one body that floats: {why}"
        raise ModelError(path, "model", found, allowed)
    joints = [plant.get_joint(index) for index in plant.GetJointIndices()]
    context = plant.CreateDefaultContext()
    limits = plant.GetPositionLowerLimits(), plant.GetPositionUpperLimits()
    plant.SetPositions(context, np.clip(plant.GetPositions(context), *limits))
    moving = [joint for joint in joints if joint.num_velocities() == 1]
    instances = [ModelInstanceIndex(i) for i in range(2, plant.num_model_instances())]
    names = Names(plant, instances, bases[0].name())
    tree, X_WR = FloatingTree(plant), bases[0].body_frame().CalcPoseInWorld(context)
    com = X_WR.inverse() @ tree.com(context)
    return Skeleton(model, plant, scene_graph, context, names, com, bases[0], moving)
