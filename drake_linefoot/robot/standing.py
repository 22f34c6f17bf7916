"""Whether a robot can stand as it is described: what is wrong is said when it is loaded."""

from __future__ import annotations

import numpy as np
from pydrake.multibody.tree import JacobianWrtVariable

from drake_linefoot.constants import GRAVITY
from drake_linefoot.errors import ModelError
from drake_linefoot.robot.chains import Robot, foot_in_link, revolute_chain
from drake_linefoot.robot.description import SIDES
from drake_linefoot.robot.mirror import joint_lines, mirror_sign
from drake_linefoot.robot.model_file import ModelFile
from drake_linefoot.robot.shapes import Cloud, cloud_of, drawn_plant
from drake_linefoot.types import Array

FLAT, ROLLED = 0.03, 0.15  # [rad] by which a line may be off level, and a sole about it
AHEAD = 0.9  # [-] least cosine between the line of a foot and the torso's x axis
ACROSS = 0.9  # [-] least cosine between the last axis of a leg and the foot's y axis
STRAIGHT = 0.05  # [-] least singular value of the Jacobian of a leg with lengths by its own
OFF_SHAPE = 0.05  # [-] of the length of the line
LONGER = 1.02  # [-] of their length: what legs may be asked to reach
SKEW = 0.05  # [-] of the height of the hips: how far the feet may be from mirror images

Clouds = list[Cloud | None]  # of the feet


def check_standing(robot: Robot, clouds: Clouds) -> list[str]:
    """Check that the nominal posture stands and that legs are as the controller takes them.

    Args:
        robot: the robot.
        clouds: of `foot_clouds`.

    Returns:
        What may fail later, a line each.

    Raises:
        ModelError: something is wrong; names the entry of the description.
    """
    for side in range(len(SIDES)):
        list(revolute_chain(robot, side))
        foot_in_link(robot, side)
    _check_feet(robot)
    _check_contact_points(robot, clouds)
    _check_legs(robot)
    _check_mirror(robot)
    _check_balance(robot)
    _check_reach(robot)
    return _check_effort(robot)


def _error(robot: Robot, entry: str, value: object, allowed: str) -> ModelError:
    return ModelError(robot.description.file, entry, value, allowed)


def line_jacobian(robot: Robot, side: int) -> Array:
    """Return the Jacobian of a leg's line at the configuration in `robot.scratch`.

    Rows are the velocity of C by the leg's length and the angular velocity about y and z of F.

    Returns:
        [1/s, rad/s per rad/s], shape (5, n_leg).
    """
    frame, base = robot.foot_frames[side], robot.base.body_frame()
    J = robot.plant.CalcJacobianSpatialVelocity(
        robot.scratch, JacobianWrtVariable.kV, frame, robot.p_FC[side], base, base
    )[:, robot.leg_v[side]]
    X_BF = frame.CalcPose(robot.scratch, base)
    length = float(np.linalg.norm(X_BF @ robot.p_FC[side]))
    across: Array = X_BF.rotation().matrix()[:, 1:].T @ J[:3]
    return np.vstack([J[3:] / length, across])


def standing_torques(robot: Robot) -> tuple[Array, Array]:
    """Return what the legs hold when the robot stands still on both feet, and on one.

    On both, half the weight is under each line. On one, the robot leans over, rigid about its
    line, until the centre of mass is above it.

    Returns:
        (both, one): joint torques of the loaded leg [N m], shapes (2, n_leg).
    """
    plant, context, nominal = robot.plant, robot.scratch, robot.q_nominal
    plant.SetPositions(context, nominal)
    com = plant.CalcCenterOfMassPositionInWorld(context)
    both, one = [], []
    for side, frame in enumerate(robot.foot_frames):
        plant.SetPositions(context, nominal)
        over = com - frame.CalcPoseInWorld(context) @ robot.p_FC[side]
        both.append(_holding(robot, side, nominal, 0.5))
        lean = nominal.copy()
        half = 0.5 * np.arctan2(over[1], over[2])
        lean[:4] = np.cos(half), np.sin(half), 0.0, 0.0
        one.append(_holding(robot, side, lean, 1.0))
    return np.array(both), np.array(one)


def _holding(robot: Robot, side: int, q: Array, share: float) -> Array:
    """Return torques of a leg whose foot carries a share of the weight, straight up."""
    plant, context, W = robot.plant, robot.scratch, robot.world
    plant.SetPositions(context, q)
    gravity = plant.CalcGravityGeneralizedForces(context)
    J = plant.CalcJacobianSpatialVelocity(
        context, JacobianWrtVariable.kV, robot.foot_frames[side], robot.p_FC[side], W, W
    )
    torque: Array = -gravity + J[3:].T @ (share * robot.mass * GRAVITY)
    return torque[robot.leg_v[side]]


def _check_feet(robot: Robot) -> None:
    plant, context, feet = robot.plant, robot.scratch, robot.description.feet
    plant.SetPositions(context, robot.q_nominal)
    poses = [frame.CalcPoseInWorld(context) for frame in robot.foot_frames]
    for i, (X, foot) in enumerate(zip(poses, feet, strict=True)):
        R = X.rotation().matrix()
        if R[0, 0] < AHEAD:
            allowed = "must have its x axis along the line, ahead of the robot"
            raise _error(robot, f"feet[{i}].frame", foot.frame, allowed)
        if R[2, 2] < 0.0:
            raise _error(robot, f"feet[{i}].frame", foot.frame, "must have its z axis up")
        pitch, roll = np.arcsin(-R[2, 0]), np.arctan2(R[2, 1], R[2, 2])
        if abs(pitch) > FLAT or abs(roll) > ROLLED:
            allowed = f"soles must be flat: {foot.name} is off by {np.degrees(pitch):.1f} degrees"
            allowed += f" in pitch, {np.degrees(roll):.1f} in roll"
            raise _error(robot, "nominal_posture", foot.name, allowed)
    p_WC = np.array([X @ p for X, p in zip(poses, robot.p_FC, strict=True)])
    if not p_WC[0, 1] > p_WC[1, 1]:
        raise _error(robot, "feet[0].frame", feet[0].frame, "must be on the left, at larger y")
    p_WB = robot.q_nominal[4:7]
    com = plant.CalcCenterOfMassPositionInWorld(context)
    if com[2] < 2.0 * robot.half_length:
        allowed = f"must have z up, above the feet: its centre of mass is {com[2]:.3f} m high"
        raise _error(robot, "floating_base", robot.description.floating_base, allowed)
    level = SKEW * p_WB[2] if p_WB[2] > 0.0 else np.inf
    if abs(p_WC[0, 2] - p_WC[1, 2]) > level:
        allowed = "both soles must be on the ground"
        raise _error(robot, "nominal_posture", "feet", allowed)


def foot_clouds(robot: Robot, model: ModelFile) -> Clouds:
    """Return the collision shapes of each foot, in its foot frame; None for one without."""
    plant, scene_graph = drawn_plant(model, robot.description.file)
    clouds: Clouds = []
    for frame in robot.foot_frames:
        welded = robot.plant.GetBodiesWeldedTo(frame.body())
        poses = {
            plant.GetBodyByName(body.name()): body.body_frame().CalcPose(robot.scratch, frame)
            for body in welded
            if plant.HasBodyNamed(body.name())
        }
        cloud, of_shapes = cloud_of(plant, scene_graph, poses) or (None, False)
        clouds.append(cloud if of_shapes else None)
    return clouds


def _check_contact_points(robot: Robot, clouds: Clouds) -> None:
    """Check that heel and toe are on the underside of the feet's collision shapes, if any."""
    tolerance = OFF_SHAPE * 2.0 * robot.half_length
    for i, (cloud, foot) in enumerate(zip(clouds, robot.description.feet, strict=True)):
        if cloud is None:
            continue
        axes = np.eye(3)
        low = np.array([-cloud.reach(-axis) for axis in axes])
        high = np.array([cloud.reach(axis) for axis in axes])
        high[2] = low[2]  # the underside
        off = np.maximum(low - foot.contact_points, foot.contact_points - high).max(axis=0)
        for axis, distance in zip("xyz", off, strict=True):
            if distance > tolerance:
                allowed = f"must be on the foot's shapes: {distance:.3f} m off them along {axis}"
                points = foot.contact_points.tolist()
                raise _error(robot, f"feet[{i}].contact_points", points, allowed)


def _check_legs(robot: Robot) -> None:
    plant, context = robot.plant, robot.scratch
    plant.SetPositions(context, robot.q_nominal)
    for side, foot in enumerate(robot.description.feet):
        entry = f"feet[{side}].leg_joints"
        joints = [plant.GetJointByName(name) for name in foot.leg_joints]
        last = joints[-1]
        R_FJ = last.frame_on_parent().CalcPose(context, robot.foot_frames[side]).rotation()
        if abs((R_FJ @ last.revolute_axis())[1]) < ACROSS:
            allowed = "the last joint must turn the foot across its line, as an ankle pitch does"
            raise _error(robot, entry, last.name(), allowed)
        least = float(np.linalg.svd(line_jacobian(robot, side), compute_uv=False)[-1])
        if least < STRAIGHT:
            allowed = f"legs must be bent and not singular (least singular value {least:.3f})"
            raise _error(robot, "nominal_posture", foot.name, allowed)


def _check_mirror(robot: Robot) -> None:
    d, plant, context = robot.description, robot.plant, robot.scratch
    names, base = list(d.actuated_joints), robot.base.body_frame()
    _, axes = joint_lines(plant, context, base, names)
    for left, (right, sign) in d.mirror.items():
        i, j = names.index(str(left)), names.index(right)
        wanted = mirror_sign(axes[i], axes[j])
        if sign != wanted:
            allowed = f"must be {wanted:g}, as the axes say"
            raise _error(robot, f"mirror.{left}", [right, int(sign)], allowed)
    q = robot.q_nominal.copy()
    q[robot.leg_q[0]] += [0.1, 0.12, 0.14, 0.16, 0.18][: len(robot.leg_q[0])]
    mirrored = robot.mirror_state(np.concatenate([q, np.zeros(plant.num_velocities())]))[: len(q)]
    places = []
    for positions in (q, mirrored):
        plant.SetPositions(context, positions)
        both = zip(robot.foot_frames, robot.p_FC, strict=True)
        places.append(np.array([frame.CalcPose(context, base) @ p for frame, p in both]))
    gap = float(np.abs(places[0] - places[1][::-1] * [1.0, -1.0, 1.0]).max())
    if gap > SKEW * float(np.abs(places[0][:, 2]).max()):
        allowed = f"legs must be mirror images: feet are {gap:.3f} m off, see mirror and leg_joints"
        raise _error(robot, "feet[1].leg_joints", SIDES[1], allowed)


def _check_balance(robot: Robot) -> None:
    plant, context = robot.plant, robot.scratch
    plant.SetPositions(context, robot.q_nominal)
    com = plant.CalcCenterOfMassPositionInWorld(context)
    X = [frame.CalcPoseInWorld(context) for frame in robot.foot_frames]
    p_WC = np.array([pose @ p for pose, p in zip(X, robot.p_FC, strict=True)])
    off = float(com[0] - p_WC[:, 0].mean())
    if abs(off) > robot.half_length:
        allowed = f"centre of mass must be over the lines: it is {off:.3f} m off their middle"
        raise _error(robot, "nominal_posture", "centre of mass", allowed)
    if not p_WC[1, 1] < com[1] < p_WC[0, 1]:
        allowed = f"centre of mass must be between the feet: it is at y = {com[1]:.3f} m"
        raise _error(robot, "nominal_posture", "centre of mass", allowed)


def _check_reach(robot: Robot) -> None:
    """Check that no limit of steps asks for more than the length of the legs.

    The hips are as far above the soles as in the nominal posture, more or less what the centre of
    mass is higher or lower; joint stops are not looked at.
    """
    plant, context, limits = robot.plant, robot.scratch, robot.description.limits
    plant.SetPositions(context, robot.q_nominal)
    com = plant.CalcCenterOfMassPositionInWorld(context)
    joints = [plant.GetJointByName(n) for n in robot.description.feet[0].leg_joints]
    p = [j.frame_on_child().CalcPoseInWorld(context).translation() for j in joints]
    p.append(robot.foot_frames[0].CalcPoseInWorld(context) @ robot.p_FC[0])
    length = float(np.linalg.norm(np.diff(p, axis=0), axis=1).sum())
    hip = p[0] - p[-1]
    wider = 0.5 * limits.step_width_max - float(p[-1][1])
    for entry, ahead, out, height in (
        ("com_height_max", 0.0, 0.0, limits.com_height_max),
        ("step_length", 0.5 * limits.step_length, 0.0, limits.com_height_min),
        ("step_width_max", 0.0, max(wider, 0.0), limits.com_height_min),
    ):
        need = np.hypot(np.hypot(ahead, out - hip[1] if out else 0.0), hip[2] + height - com[2])
        if need > LONGER * length:
            allowed = f"is out of reach: needs legs of {need:.3f} m, they are {length:.3f} m long"
            raise _error(robot, f"limits.{entry}", getattr(limits, entry), allowed)


def _check_effort(robot: Robot) -> list[str]:
    """Check torque limits against what standing takes."""
    limits = dict(zip(robot.description.actuated_joints, robot.effort_limits, strict=True))
    lines = []
    both, one = standing_torques(robot)
    for side, foot in enumerate(robot.description.feet):
        for i, name in enumerate(foot.leg_joints):
            limit = float(limits[name])
            if abs(both[side, i]) > limit:
                allowed = f"cannot stand: {name} needs {abs(both[side, i]):.1f} N m on two legs"
                raise _error(robot, "model", name, f"{allowed} and has {limit:.1f}")
            if abs(one[side, i]) > limit:
                needs = f"{abs(one[side, i]):.1f} N m of {limit:.1f}"
                lines.append(f"{name} needs {needs} to stand on one leg: it will not walk well")
    return lines
