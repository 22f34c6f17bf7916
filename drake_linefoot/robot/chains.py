"""The legs as chains of joints in the model, from the torso to the feet."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, Frame, JacobianWrtVariable, RevoluteJoint, RigidBody

from drake_linefoot.axes import WRENCH
from drake_linefoot.contact.contacts import Contact
from drake_linefoot.robot.description import HumanoidDescription
from drake_linefoot.robot.floating_tree import FloatingTree
from drake_linefoot.robot.names import Names
from drake_linefoot.types import Array

if TYPE_CHECKING:
    from pydrake.systems.framework import Context

_IN_LINE = np.eye(3)
_COORDINATES = {  # of a contact, by how many
    5: "position of the line and its pitch and yaw",
    6: "position of the sole and its pitch, yaw and roll",
}


class Robot(Protocol):
    """What is asked of a robot here and in `standing`, see `Humanoid`."""

    description: HumanoidDescription
    plant: MultibodyPlant
    names: Names
    scratch: Context
    world: Frame
    base: Any
    mass: float
    floating: FloatingTree
    contact: Contact
    half_length: float
    half_width: float
    p_FC: Array
    foot_frames: list[Frame]
    leg_joints: Array
    leg_q: Array
    leg_v: Array
    effort_limits: Array
    q_nominal: Array
    actuated_q: Array
    position_lower: Array
    position_upper: Array

    def mirror_state(self, x: Array) -> Array:
        """Mirror a state in the plane y = 0."""


def foot_in_link(robot: Robot, side: int) -> RigidTransform:
    """Return X_LF: the foot's frame in that of the last joint's child, to which it is welded."""
    plant, foot = robot.plant, robot.description.feet[side]
    last = robot.names.joint(foot.leg_joints[-1]).frame_on_child()
    frame = robot.foot_frames[side]
    if frame.body().index() == last.body().index():
        return last.GetFixedPoseInBodyFrame().inverse() @ frame.GetFixedPoseInBodyFrame()
    if frame.body().index() not in _welded(plant, last.body()):
        entry, allowed = f"feet[{side}].leg_joints", "the chain must end at the foot"
        raise robot.description.refuse(entry, foot.frame, allowed)
    return frame.CalcPose(robot.scratch, last)


def _welded(plant: MultibodyPlant, body: RigidBody) -> set[BodyIndex]:
    return {each.index() for each in plant.GetBodiesWeldedTo(body)}


def revolute_chain(robot: Robot, side: int) -> Iterator[tuple[RigidTransform, RevoluteJoint]]:
    """Yield the joints of a leg, and where each is in the child frame of the one before.

    Raises:
        ModelError: they are not what `read_legs` needs.
    """
    plant, foot = robot.plant, robot.description.feet[side]
    entry = f"feet[{side}].leg_joints"
    if len(foot.leg_joints) != robot.contact.size:
        allowed = f"must name {robot.contact.size} joints: {_COORDINATES[robot.contact.size]}"
        raise robot.description.refuse(entry, list(foot.leg_joints), allowed)
    before = robot.base.body_frame()
    for name in foot.leg_joints:
        joint = robot.names.joint(name)
        parent = joint.frame_on_parent()
        chained = joint.parent_body().index() in _welded(plant, before.body())
        if not isinstance(joint, RevoluteJoint) or not chained:
            raise robot.description.refuse(entry, name, "is not next in a revolute chain")
        if joint.parent_body().index() == before.body().index():
            X = before.GetFixedPoseInBodyFrame().inverse() @ parent.GetFixedPoseInBodyFrame()
        else:
            X = parent.CalcPose(robot.scratch, before)
        yield X, joint
        before = joint.frame_on_child()


def least_mobility(
    plant: MultibodyPlant,
    context: Context,
    base: Frame,
    frame: Frame,
    p: Array,
    joints: Array,
    hip: Array,
    R: Array = _IN_LINE,
) -> float:
    """Return the least singular value of the Jacobian of a leg's contact, 0 for a singular leg.

    Its rows are the velocity of C by its distance from the hip, which is in B [m], shape (3,), and
    the angular velocity about y and z of a line, or about all axes where there are six joints.
    C is in the frame of the foot at p [m], shape (3,), with axes R, shape (3, 3); the joints are
    those of the leg, as they are in v.
    """
    by_velocity = JacobianWrtVariable.kV
    J = plant.CalcJacobianSpatialVelocity(context, by_velocity, frame, p, base, base)[:, joints]
    X = frame.CalcPose(context, base)
    turns = (X.rotation().matrix() @ R).T @ J[:3]
    across = turns if len(joints) == len(WRENCH) else turns[1:]
    E = np.vstack([J[3:] / np.linalg.norm(X @ p - hip), across])
    return float(np.linalg.svd(E, compute_uv=False)[-1])
