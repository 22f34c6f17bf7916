"""The tree of links, masses and inertias of a robot, read from a plant and a context of it."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    BodyIndex,
    Frame,
    PrismaticJoint,
    RevoluteJoint,
    RigidBody,
    WeldJoint,
)

from drake_linefoot.robot.tree import BASE_VELOCITIES, IN_V, Tree
from drake_linefoot.types import Array

if TYPE_CHECKING:
    from pydrake.systems.framework import Context

_ALONG = 2  # the axis of a link's frame that its joint has


class _Links:
    """The links found so far: what is welded together, and how it hangs on the others."""

    def __init__(self, base: RigidBody) -> None:
        """Begin with the base."""
        self.frames, self.turns = [base.body_frame()], [RotationMatrix()]  # R of L in that frame
        self.bodies: list[list[BodyIndex]] = [[]]
        self.joints, self.X_PL = [[-1, 0, 0, 0]], [RigidTransform()]

    def add(self, on: int, joint: RevoluteJoint | PrismaticJoint, context: Context) -> int:
        """Add what a joint moves against the link `on`; return its number."""
        slides = isinstance(joint, PrismaticJoint)
        axis = joint.translation_axis() if slides else joint.revolute_axis()
        turn = RotationMatrix.MakeFromOneVector(axis, _ALONG)
        X_PF = self.pose(on, joint.frame_on_parent(), context)
        self.X_PL.append(X_PF @ RigidTransform(turn, np.zeros(3)))
        self.joints.append([on, int(slides), joint.position_start(), joint.velocity_start()])
        self.frames.append(joint.frame_on_child())
        self.turns.append(turn)
        self.bodies.append([])
        return len(self.joints) - 1

    def pose(self, link: int, frame: Frame, context: Context) -> RigidTransform:
        """Return the pose of a frame of a link in L."""
        X_LM = RigidTransform(self.turns[link].inverse(), np.zeros(3))
        return X_LM @ frame.CalcPose(context, self.frames[link])


def read_tree(
    plant: MultibodyPlant,
    context: Context,
    base: RigidBody,
    foot_frames: Sequence[Frame],
    p_FC: Array,
) -> Tree | None:
    """Return the tree that a floating base carries, with the masses of a context.

    Args:
        plant: with the robot; finalized.
        context: of it, for masses, inertias and rotors; its state does not matter.
        base: body B.
        foot_frames: frames F of the feet, left before right.
        p_FC: middle of each contact line in its foot [m], shape (2, 3).

    Returns:
        None when the tree is not all that moves in the plant, or has joints that are neither
        revolute nor prismatic.
    """
    q = plant.GetPositions(context)
    plant.SetPositions(context, plant.GetDefaultPositions())  # or last bits would go by the state
    links = _links(plant, context, base)
    tree = _tree(plant, context, links, foot_frames, p_FC) if links else None
    plant.SetPositions(context, q)
    return tree


def _links(plant: MultibodyPlant, context: Context, base: RigidBody) -> _Links | None:
    """Return the links that hang on the base, where they are a tree and all that moves."""
    hanging = defaultdict(list)
    for index in plant.GetJointIndices():
        joint = plant.get_joint(index)
        hanging[joint.parent_body().index()].append(joint)
    links, left = _Links(base), [(0, base.index())]
    while left:
        link, body = left.pop()
        links.bodies[link].append(body)
        for joint in hanging[body]:
            if isinstance(joint, WeldJoint):
                left.append((link, joint.child_body().index()))
            elif isinstance(joint, RevoluteJoint | PrismaticJoint):
                left.append((links.add(link, joint, context), joint.child_body().index()))
            else:
                return None
    moves = BASE_VELOCITIES + len(links.joints) - 1
    if not base.has_quaternion_dofs() or moves != plant.num_velocities():
        return None
    return links


def _tree(
    plant: MultibodyPlant,
    context: Context,
    links: _Links,
    foot_frames: Sequence[Frame],
    p_FC: Array,
) -> Tree:
    """Return the tree of all links."""
    at = {body: link for link, bodies in enumerate(links.bodies) for body in bodies}
    feet = [at[frame.body().index()] for frame in foot_frames]
    X_LF = [
        links.pose(link, frame, context) @ RigidTransform(p)
        for link, frame, p in zip(feet, foot_frames, p_FC, strict=True)
    ]
    rotors = np.zeros(plant.num_velocities())
    for index in plant.GetJointActuatorIndices():
        motor = plant.get_joint_actuator(index)
        rotors[motor.joint().velocity_start()] += motor.calc_reflected_inertia(context)
    mass, inertia = np.zeros((len(links.joints), 2)), np.zeros((len(links.joints), 3, 4))
    for i, (frame, turn) in enumerate(zip(links.frames, links.turns, strict=True)):
        mass[i, 0], com, about = rigid_body(plant, context, frame, links.bodies[i])
        R = turn.matrix()
        inertia[i, :, :3], inertia[i, :, 3] = R.T @ about @ R, R.T @ com
        if i:
            mass[i, 1] = rotors[links.joints[i][IN_V]]
    return Tree(
        joints=np.array(links.joints),
        X_PL=np.array([X.GetAsMatrix34() for X in links.X_PL]),
        mass=mass,
        inertia=inertia,
        feet=np.array(feet),
        X_LF=np.array([X.GetAsMatrix34() for X in X_LF]),
    )


def rigid_body(
    plant: MultibodyPlant, context: Context, frame: Frame, bodies: Sequence[BodyIndex]
) -> tuple[float, Array, Array]:
    """Return what bodies weigh together, with the joints as they are in the context.

    Returns:
        (m, com, I): mass [kg], centre of mass in the frame [m], shape (3,), and inertia about
        that centre in the frame's axes [kg m^2], shape (3, 3).
    """
    spatial = plant.CalcSpatialInertia(context, frame, bodies)
    mass: float = spatial.get_mass()
    if mass == 0.0:
        return 0.0, np.zeros(3), np.zeros((3, 3))
    com = spatial.get_com()
    central = spatial.Shift(com).CalcRotationalInertia()
    return mass, com, central.CopyToFullMatrix3()
