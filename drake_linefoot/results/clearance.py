"""How far the two legs of a recorded run are from each other."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import (
    Capsule,
    FrameId,
    FramePoseVector,
    GeometryFrame,
    GeometryId,
    GeometryInstance,
    ProximityProperties,
    SceneGraph,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.tree import Frame

from drake_linefoot.robot.humanoid import Humanoid, load_humanoid

Array = NDArray[np.float64]

LIMB_RADIUS = 0.02  # [m] of shank and foot as capsules: half the width of the pad, its README

humanoid_named = cache(load_humanoid)


def leg_clearance(humanoid: Humanoid, q: Array) -> Array:
    """Return the gap between the legs; negative where they are inside each other.

    Foot and shank of each leg are capsules, from heel to toe above the contact line and from
    knee to ankle. The simulator knows nothing of shanks and pads: it lets legs pass.

    Args:
        humanoid: the robot.
        q: configurations, shape (n, nq).

    Returns:
        The smallest gap [m], shape (n,).
    """
    plant = humanoid.plant
    context = plant.CreateDefaultContext()
    scene = SceneGraph()
    source = scene.RegisterSource("legs")
    up = np.array([0.0, 0.0, LIMB_RADIUS])
    placed: dict[FrameId, Frame] = {}
    legs: tuple[list[GeometryId], ...] = ([], [])
    for side, foot in enumerate(humanoid.description.feet):
        knee, ankle = (plant.GetJointByName(name) for name in foot.leg_joints[-2:])
        shank, X_KA = knee.frame_on_child(), ankle.frame_on_parent()
        p_KA = X_KA.CalcPose(context, shank).translation()
        for frame, ends in (
            (humanoid.foot_frames[side], foot.contact_points + up),
            (shank, np.array([np.zeros(3), p_KA])),
        ):
            name = f"{foot.name} {frame.name()}"
            moving = scene.RegisterFrame(source, GeometryFrame(name))
            placed[moving] = frame
            limb = scene.RegisterGeometry(source, moving, _capsule(ends, name))
            legs[side].append(limb)
    poses = scene.get_source_pose_port(source)
    scene_context = scene.CreateDefaultContext()
    gaps = np.empty(len(q))
    for i, row in enumerate(q):
        plant.SetPositions(context, row)
        X_WF = FramePoseVector()
        for moving, frame in placed.items():
            X_WF.set_value(moving, frame.CalcPoseInWorld(context))
        poses.FixValue(scene_context, X_WF)
        query = scene.get_query_output_port().Eval(scene_context)
        gaps[i] = min(
            query.ComputeSignedDistancePairClosestPoints(left, right).distance
            for left in legs[0]
            for right in legs[1]
        )
    return gaps


def _capsule(ends: Array, name: str) -> GeometryInstance:
    """Return a limb between the centres of its round ends [m], shape (2, 3)."""
    along = ends[1] - ends[0]
    X_FC = RigidTransform(RotationMatrix.MakeFromOneVector(along, 2), ends.mean(axis=0))
    capsule = GeometryInstance(X_FC, Capsule(LIMB_RADIUS, float(np.linalg.norm(along))), name)
    capsule.set_proximity_properties(ProximityProperties())
    return capsule
