"""How far the legs of a recorded run are from each other, and shanks from the ground."""

import numpy as np
from pydrake.geometry import Capsule, GeometryId, ProximityProperties
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, MultibodyPlant
from pydrake.multibody.tree import Frame
from pydrake.systems.framework import DiagramBuilder

from drake_linefoot.lab.plants.ground import Ground
from drake_linefoot.lab.simulation.recording import Run
from drake_linefoot.lab.simulation.run_view import robot_of
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.legs import contact_from_ankle, leg_roles
from drake_linefoot.robot.scaling import units_of
from drake_linefoot.types import Array

LIMB_RADIUS = 0.02  # [m] of the MIT Humanoid's limbs as capsules: half the width of its pad, README
STRIDE = 5  # samples between two looks
ALONG = 12  # points of a shank that are looked at
SHORTEST = 0.01  # [-] of a limb: what a capsule keeps between its round ends


def limb_radius(humanoid: Humanoid) -> float:
    """Return the radius of the shanks of a robot as capsules [m], in its size."""
    return LIMB_RADIUS * units_of(humanoid)["m"]


def leg_clearance(humanoid: Humanoid, q: Array) -> Array:
    """Return the gap between the legs; negative where they are inside each other.

    Foot and shank of each leg are capsules, from heel to toe above the contact line and from
    knee to ankle; a foot is at least as wide as its sole. The simulator knows nothing of shanks
    and pads: it lets legs pass.

    Args:
        humanoid: the robot.
        q: configurations, shape (n, nq).

    Returns:
        The smallest gap [m], shape (n,).
    """
    builder = DiagramBuilder()
    plant, scene = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
    humanoid.add_to(plant, drawn=False)
    legs = [_limbs(plant, humanoid, side) for side in (0, 1)]
    plant.Finalize()
    diagram = builder.Build()
    root = diagram.CreateDefaultContext()
    context, seen = plant.GetMyContextFromRoot(root), scene.GetMyContextFromRoot(root)
    gaps = np.empty(len(q))
    for i, row in enumerate(q):
        plant.SetPositions(context, row)
        query = scene.get_query_output_port().Eval(seen)
        gaps[i] = min(
            query.ComputeSignedDistancePairClosestPoints(left, right).distance
            for left in legs[0]
            for right in legs[1]
        )
    return gaps


def shank_clearance(humanoid: Humanoid, ground: Ground, q: Array) -> Array:
    """Return the gap between the shanks, as in `leg_clearance`, and the ground [m].

    A shank counts down to where it is as far above the ankle as that is above the contact line:
    what is below is beside the foot, which touches the ground with its ends alone, and may straddle
    an edge. The simulator lets shanks pass.

    Args:
        humanoid: the robot.
        ground: where it walks.
        q: configurations, shape (n, nq).

    Returns:
        The smaller one of both shanks [m], shape (n,).
    """
    plant, shanks = humanoid.plant, [_shank(humanoid, side) for side in (0, 1)]
    context, points = plant.CreateDefaultContext(), np.empty((len(q), 2, ALONG, 3))
    above = max(-float(contact_from_ankle(humanoid, side)[2]) for side in (0, 1))
    ends = max(1.0 - above / float(np.linalg.norm(shanks[0][1])), 0.0)
    shares = np.linspace(0.0, ends, ALONG)[:, None]
    for i, row in enumerate(q):
        plant.SetPositions(context, row)
        for side, (shank, p_KA) in enumerate(shanks):
            X_WK = shank.CalcPoseInWorld(context)
            points[i, side] = X_WK.translation() + shares * X_WK.rotation().multiply(p_KA)
    gaps: Array = ground.distance(points.reshape(-1, 3)).reshape(len(q), -1).min(axis=1)
    return gaps - limb_radius(humanoid)


def smallest_leg_gap(run: Run, before: float) -> tuple[float, float | None]:
    """Look at every `STRIDE`-th sample of a run up to a time [s].

    Returns:
        The smallest `leg_clearance` [m]; when it was first below zero [s], None when it never was.
    """
    looked_at = np.flatnonzero(run.time <= before)[::STRIDE]
    gaps = leg_clearance(robot_of(run), run.q[looked_at])
    met = looked_at[gaps < 0.0]
    return float(gaps.min()), float(run.time[met[0]]) if len(met) else None


def _limbs(plant: MultibodyPlant, humanoid: Humanoid, side: int) -> list[GeometryId]:
    """Add foot and shank of a leg to a plant that holds the robot; return their geometries."""
    foot = humanoid.description.feet[side]
    shank, p_KA = _shank(humanoid, side)
    thin = limb_radius(humanoid)
    wide, limbs = max(0.5 * humanoid.sole_width, humanoid.half_width, thin), []
    for frame, ends, radius in (
        (humanoid.foot_frames[side], foot.contact_points + np.array([0.0, 0.0, wide]), wide),
        (shank, np.array([np.zeros(3), p_KA]), thin),
    ):
        along = ends[1] - ends[0]
        X_FL = RigidTransform(RotationMatrix.MakeFromOneVector(along, 2), ends.mean(axis=0))
        body = humanoid.names_in(plant).body(frame.body().name())
        X_BL = frame.GetFixedPoseInBodyFrame() @ X_FL
        length = float(np.linalg.norm(along))  # the ends of a wide one reach no farther
        limb = Capsule(radius, max(length - 2.0 * (radius - thin), SHORTEST * length))
        name, properties = f"{foot.name} {frame.name()}", ProximityProperties()
        limbs.append(plant.RegisterCollisionGeometry(body, X_BL, limb, name, properties))
    return limbs


def _shank(humanoid: Humanoid, side: int) -> tuple[Frame, Array]:
    """Return the frame of a shank at the knee, and where the ankle is in it [m]."""
    joints, roles = humanoid.description.feet[side].leg_joints, leg_roles(humanoid)
    knee, ankle = (humanoid.names.joint(joints[k]) for k in (roles.knee, roles.ankle))
    shank = knee.frame_on_child()
    context = humanoid.plant.CreateDefaultContext()
    p_KA: Array = ankle.frame_on_parent().CalcPose(context, shank).translation()
    return shank, p_KA
