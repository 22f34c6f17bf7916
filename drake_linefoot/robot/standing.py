"""Whether a robot can stand as it is described: what is wrong is said when it is loaded."""

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.tree import JacobianWrtVariable

from drake_linefoot.checks import shown
from drake_linefoot.constants import GRAVITY
from drake_linefoot.robot.chains import Robot, foot_in_link, least_mobility, revolute_chain
from drake_linefoot.robot.description import LINE, SIDES
from drake_linefoot.robot.mirror import joint_lines, mirror_sign
from drake_linefoot.robot.model import SLACK
from drake_linefoot.robot.model_file import ModelFile
from drake_linefoot.robot.shapes import Cloud, cloud_of, drawn_plant
from drake_linefoot.types import Array

FLAT, ROLLED = 0.03, 0.15  # [rad] by which a foot may be off level, and about its line
AHEAD = 0.9  # [-] least cosine between the line of a foot and the torso's x axis
ACROSS = 0.9  # [-] least cosine between the last axis of a leg and the foot's y axis
STRAIGHT = 0.05  # [-] least singular value of the Jacobian of a leg with lengths by its own
OFF_SHAPE = 0.05  # [-] of the length of the line
LONGER = 1.02  # [-] of their length: what legs may be asked to reach
SKEW = 0.05  # [-] of the height of the hips: how far the feet may be from mirror images

Clouds = list[Cloud | None]  # of the feet


def check_standing(robot: Robot, clouds: Clouds) -> list[str]:
    """Check that the nominal posture stands and that legs are as the controller takes them.

    Returns:
        What may fail later, a line each.

    Raises:
        ModelError: something is wrong; names the entry of the description.
    """
    _check_masses(robot)
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


def stance(robot: Robot, q: Array) -> tuple[list[RigidTransform], Array, Array]:
    """Return poses of the feet, middles of their lines and centre of mass [m], (2, 3) and (3,)."""
    robot.plant.SetPositions(robot.scratch, q)
    poses = [frame.CalcPoseInWorld(robot.scratch) for frame in robot.foot_frames]
    p_WC = np.array([X @ p for X, p in zip(poses, robot.p_FC, strict=True)])
    return poses, p_WC, robot.floating.com(robot.scratch)


def standing_torques(robot: Robot, q: Array) -> tuple[Array, Array]:
    """Return what the legs hold when the robot stands still on both feet, and on one.

    On both, half the weight is under each line. On one, the robot leans over, rigid about its
    line, until the centre of mass is above it.

    Args:
        robot: the robot.
        q: upright on both feet, shape (nq,).

    Returns:
        (both, one): joint torques of the loaded leg [N m], shapes (2, n_leg).
    """
    _, p_WC, com = stance(robot, q)
    both, one = [], []
    for side, over in enumerate(com - p_WC):
        both.append(_holding(robot, side, q, 0.5))
        lean = q.copy()
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
    d, (poses, p_WC, com) = robot.description, stance(robot, robot.q_nominal)
    for i, (X, foot) in enumerate(zip(poses, d.feet, strict=True)):
        R = X.rotation().matrix()
        if R[0, 0] < AHEAD:
            allowed = "must have its x axis along the line, ahead of the robot"
            raise d.refuse(f"feet[{i}].frame", foot.frame, allowed)
        if R[2, 2] < 0.0:
            raise d.refuse(f"feet[{i}].frame", foot.frame, "must have its z axis up")
        pitch, roll = np.arcsin(-R[2, 0]), np.arctan2(R[2, 1], R[2, 2])
        if abs(pitch) > FLAT or abs(roll) > (ROLLED if d.contact == LINE else FLAT):
            allowed = f"soles must be flat: {foot.name} is off by {np.degrees(pitch):.1f} degrees"
            allowed += f" in pitch, {np.degrees(roll):.1f} in roll"
            raise d.refuse("nominal_posture", foot.name, allowed)
    if not p_WC[0, 1] > p_WC[1, 1]:
        raise d.refuse("feet[0].frame", d.feet[0].frame, "must be on the left, at larger y")
    if com[2] < 2.0 * robot.half_length:
        allowed = f"must have z up, above the feet: its centre of mass is {com[2]:.3f} m high"
        raise d.refuse("floating_base", d.floating_base, allowed)
    if abs(p_WC[0, 2] - p_WC[1, 2]) > SKEW * com[2]:
        allowed = "both soles must be on the ground"
        raise d.refuse("nominal_posture", "feet", allowed)


def foot_clouds(robot: Robot, model: ModelFile) -> Clouds:
    """Return the collision shapes of each foot, in its foot frame; None for one without."""
    plant, scene_graph = drawn_plant(model, robot.description.file)
    clouds: Clouds = []
    for frame in robot.foot_frames:
        welded = robot.plant.GetBodiesWeldedTo(frame.body())
        poses = {
            plant.GetBodyByName(*place): body.body_frame().CalcPose(robot.scratch, frame)
            for body in welded
            for place in [(body.name(), body.model_instance())]  # the same in both plants
            if plant.HasBodyNamed(*place)
        }
        cloud, of_shapes = cloud_of(plant, scene_graph, poses) or (None, False)
        clouds.append(cloud if of_shapes else None)
    return clouds


def _check_masses(robot: Robot) -> None:
    """Check that whatever moves has a mass, or a motor whose rotor has an inertia."""
    plant = robot.plant
    motors = map(plant.get_joint_actuator, plant.GetJointActuatorIndices())
    turned = {m.joint().index() for m in motors if m.default_reflected_inertia() > 0.0}
    for joint in map(plant.get_joint, plant.GetJointIndices()):
        if not joint.num_velocities() or joint.index() in turned:
            continue
        moved = plant.GetBodiesKinematicallyAffectedBy([joint.index()])
        if not sum(plant.get_body(index).default_mass() for index in moved) > 0.0:
            allowed = "moves and has no mass, nor has what it carries: its inertia is missing"
            raise robot.description.refuse("model", shown(joint.child_body().name()), allowed)


def _check_contact_points(robot: Robot, clouds: Clouds) -> None:
    """Check that contact points are on the underside of the feet's collision shapes, if any."""
    d, tolerance = robot.description, OFF_SHAPE * 2.0 * robot.half_length
    for i, (cloud, foot) in enumerate(zip(clouds, d.feet, strict=True)):
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
                raise d.refuse(f"feet[{i}].contact_points", points, allowed)
        corners = foot.ground_points[:, 1]
        beyond = float(max(low[1] - corners.min(), corners.max() - high[1]))
        if foot.contact_width and beyond > tolerance:
            allowed = f"must be on the foot's shapes: its edge is {beyond:.3f} m off them"
            raise d.refuse(f"feet[{i}].contact_width", foot.contact_width, allowed)


def _check_legs(robot: Robot) -> None:
    d, plant, context = robot.description, robot.plant, robot.scratch
    plant.SetPositions(context, robot.q_nominal)
    for side, foot in enumerate(d.feet):
        entry = f"feet[{side}].leg_joints"
        joints = [robot.names.joint(name) for name in foot.leg_joints]
        last, frame = joints[-2:], robot.foot_frames[side]
        R_FJ = [joint.frame_on_parent().CalcPose(context, frame).rotation() for joint in last]
        axes = np.abs([R @ joint.revolute_axis() for R, joint in zip(R_FJ, last, strict=True)])
        if robot.half_width == 0.0 and axes[1, 1] < ACROSS:
            allowed = "the last joint must turn the foot across its line, as an ankle pitch does"
            raise d.refuse(entry, foot.leg_joints[-1], allowed)
        if robot.half_width > 0.0 and axes[:, :2].max(axis=0).min() < ACROSS:
            allowed = "the last two joints must pitch and roll the sole"
            raise d.refuse(entry, list(foot.leg_joints[-2:]), allowed)
        p, base = robot.p_FC[side], robot.base.body_frame()
        hip = joints[0].frame_on_parent().CalcPose(context, base).translation()
        least = least_mobility(plant, context, base, frame, p, robot.leg_v[side], hip)
        if least < STRAIGHT:
            allowed = f"legs must be bent and not singular (least singular value {least:.3f})"
            raise d.refuse("nominal_posture", foot.name, allowed)


def _check_mirror(robot: Robot) -> None:
    d, plant, context = robot.description, robot.plant, robot.scratch
    names, base = list(d.actuated_joints), robot.base.body_frame()
    _, axes = joint_lines(robot.names, base, names)
    for left, (right, sign) in d.mirror.items():
        i, j = names.index(str(left)), names.index(right)
        wanted = mirror_sign(axes[i], axes[j])
        if sign != wanted:
            allowed = f"must be {wanted:g}, as the axes say"
            raise d.refuse(f"mirror.{left}", [right, int(sign)], allowed)
    q = robot.q_nominal.copy()
    q[robot.leg_q[0]] += [0.1, 0.12, 0.14, 0.16, 0.18, 0.2][: len(robot.leg_q[0])]
    mirrored = robot.mirror_state(np.concatenate([q, np.zeros(plant.num_velocities())]))[: len(q)]
    places = []
    for positions in (q, mirrored):
        plant.SetPositions(context, positions)
        both = zip(robot.foot_frames, robot.p_FC, strict=True)
        places.append(np.array([frame.CalcPose(context, base) @ p for frame, p in both]))
    gap = float(np.abs(places[0] - places[1][::-1] * [1.0, -1.0, 1.0]).max())
    plant.SetPositions(context, q)
    hip = robot.names.joint(d.feet[0].leg_joints[0]).frame_on_parent().CalcPose(context, base)
    if gap > SKEW * float(np.abs(places[0][:, 2] - hip.translation()[2]).max()):
        allowed = f"legs must be mirror images: feet are {gap:.3f} m off, see mirror and leg_joints"
        raise d.refuse("feet[1].leg_joints", SIDES[1], allowed)


def _check_balance(robot: Robot) -> None:
    d, (_, p_WC, com) = robot.description, stance(robot, robot.q_nominal)
    off = float(com[0] - p_WC[:, 0].mean())
    if abs(off) > robot.half_length:
        allowed = f"centre of mass must be over the lines: it is {off:.3f} m off their middle"
        raise d.refuse("nominal_posture", "centre of mass", allowed)
    if not p_WC[1, 1] < com[1] < p_WC[0, 1]:
        allowed = f"centre of mass must be between the feet: it is at y = {com[1]:.3f} m"
        raise d.refuse("nominal_posture", "centre of mass", allowed)


def _check_reach(robot: Robot) -> None:
    """Check that no limit of steps asks for more than the length of the legs.

    The hips are as far above the soles as in the nominal posture, more or less what the centre of
    mass is higher or lower; joint stops are not looked at.
    """
    d, context = robot.description, robot.scratch
    limits, (_, p_WC, com) = d.limits, stance(robot, robot.q_nominal)
    joints = [robot.names.joint(name) for name in d.feet[0].leg_joints]
    p = [j.frame_on_child().CalcPoseInWorld(context).translation() for j in joints]
    p.append(p_WC[0])
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
            raise d.refuse(f"limits.{entry}", getattr(limits, entry), allowed)


def _check_effort(robot: Robot) -> list[str]:
    """Check torque limits against what standing takes."""
    d, limits, lines = robot.description, robot.effort_limits[robot.leg_joints], []
    both, one = np.abs(standing_torques(robot, robot.q_nominal))
    for side, foot in enumerate(d.feet):
        for name, limit, on_both, on_one in zip(
            foot.leg_joints, limits[side], both[side], one[side], strict=True
        ):
            if on_both > limit:
                allowed = f"cannot stand: {name} needs {on_both:.1f} N m on two legs"
                raise d.refuse("model", name, f"{allowed} and has {limit:.1f}")
            if on_one > limit:
                needs = f"{on_one:.1f} N m of {limit:.1f}"
                lines.append(f"{name} needs {needs} to stand on one leg: it will not walk well")
    return lines


def nominal_configuration(robot: Robot) -> Array:
    """Return the nominal posture with the lowest contact point on z = 0, shape (nq,).

    Raises:
        ModelError: an angle is not of an actuated joint, or beyond its limits.
    """
    d, plant, context = robot.description, robot.plant, robot.scratch
    names, q = d.actuated_joints, np.zeros(plant.num_positions())
    q[0] = 1.0
    for name, angle in d.nominal_posture.items():
        if name not in names:
            raise d.refuse(f"nominal_posture.{name}", angle, "is not an actuated joint")
        q[robot.actuated_q[names.index(name)]] = angle
    joints = q[robot.actuated_q]
    lower, upper = robot.position_lower, robot.position_upper
    for i in np.flatnonzero((joints < lower - SLACK) | (joints > upper + SLACK)):
        allowed = f"must lie in [{lower[i]:g}, {upper[i]:g}]"
        raise d.refuse(f"nominal_posture.{names[i]}", float(joints[i]), allowed)
    q[robot.actuated_q] = np.clip(joints, lower, upper)
    plant.SetPositions(context, q)
    lowest = min(
        (frame.CalcPoseInWorld(context) @ foot.ground_points.T)[2].min()
        for frame, foot in zip(robot.foot_frames, d.feet, strict=True)
    )
    q[6] = -lowest
    return q
