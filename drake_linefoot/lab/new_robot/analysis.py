"""From a model to a description: the steps one after another, and what there is to say of each."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from pydrake.math import RollPitchYaw, RotationMatrix
from pydrake.multibody.tree import Joint

from drake_linefoot.checks import check
from drake_linefoot.errors import ModelError
from drake_linefoot.lab.new_robot.contact_kind import ContactKind, contact_kind
from drake_linefoot.lab.new_robot.posture import Reach, find_reach, step_limits
from drake_linefoot.lab.new_robot.skeleton import Skeleton, read_skeleton
from drake_linefoot.lab.new_robot.soles import Sole, find_sole, foot_cloud, forward_of
from drake_linefoot.lab.new_robot.topology import arms_to_keep, base_origin, find_limbs
from drake_linefoot.robot.description import SIDES, SURFACE, HumanoidDescription
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.standing import standing_torques
from drake_linefoot.types import Array

UNEQUAL = 0.05  # [-] by which both feet may differ in length, and in width
HEAVY_LEGS = 0.65  # [-] of the mass, which hardly lets a torso stay upright
DIGITS = 5
_ORIGIN = np.zeros(3)
ANY_LIMITS = {  # [m] until they are known
    **{"step_length": 1.0, "step_width_min": 0.1, "step_width_max": 1.0},
    **{"com_height_min": 0.1, "com_height_max": 10.0},
}


@dataclass
class Finding:
    """What was found of a robot.

    Attributes:
        humanoid: the robot as it is described.
        data: the description, plain.
        reach: of its legs.
        lines: what was found, changed and assumed, a line each.
    """

    humanoid: Humanoid
    data: dict[str, Any]
    reach: Reach
    lines: list[str] = field(default_factory=list)


def analyse(path: Path, lock_arms: bool = False, contact: str | None = None) -> Finding:
    """Describe the robot of a model.

    Args:
        path: of the model.
        lock_arms: whether its arms are welded to the torso.
        contact: how its feet are to touch, `LINE` or `SURFACE`; None: as they are made.

    Raises:
        ModelError: the model cannot be read, or is of no robot that can walk on such feet.
    """
    skeleton = read_skeleton(path)
    data, soles, lines = _described(skeleton, lock_arms, contact)
    data["model"] = str(path.resolve())
    humanoid = _paired(data, path, lines)
    width = max(sole.width for sole in soles)
    try:
        reach = find_reach(humanoid, width)
    except ValueError as error:
        raise skeleton.refuse(path.stem, str(error)) from error
    angles = zip(humanoid.description.actuated_joints, reach.q[humanoid.actuated_q], strict=True)
    data["nominal_posture"] = {
        name: round(float(angle), DIGITS)
        for name, angle in angles
        if abs(angle) > 0.5 * 10.0**-DIGITS
    }
    limits = step_limits(humanoid, reach, width)
    data["limits"] = {name: round(float(value), 3) for name, value in limits.items()}
    found = Humanoid(_description(data, path))
    _say_stance(lines, found, reach, width)
    return Finding(found, data, reach, [*found.notes, *lines])


def _description(data: dict[str, Any], path: Path) -> HumanoidDescription:
    return check({"file": path, **data}, HumanoidDescription, path, error=ModelError)


def _described(
    skeleton: Skeleton, lock_arms: bool, contact: str | None
) -> tuple[dict[str, Any], list[Sole], list[str]]:
    """Return a description without posture and limits, both soles, and what was found."""
    limbs, names = find_limbs(skeleton), skeleton.names
    bodies = [leg[-1].child_body() for leg in limbs.legs]
    clouds = [foot_cloud(skeleton, leg) for leg in limbs.legs]
    forward, assumed = forward_of(skeleton, limbs, [cloud for cloud, _ in clouds])
    R_RB = np.column_stack([forward, np.cross(limbs.up, forward), limbs.up])
    order = np.argsort([-skeleton.place(body.body_frame()) @ R_RB[:, 1] for body in bodies])
    legs = [limbs.legs[k] for k in order]
    soles = [find_sole(skeleton, limbs.legs[k], clouds[k][0], R_RB, clouds[k][1]) for k in order]
    kind = contact_kind(skeleton, legs, soles, contact)
    arms = [] if lock_arms else arms_to_keep(skeleton, limbs, forward)
    feet = _feet(skeleton, legs, soles, kind)
    kept = [*arms, *(name for foot in feet for name in foot["leg_joints"])]
    rest = skeleton.plant.GetPositions(skeleton.context)
    angles = {
        names.name_of(joint): round(float(rest[joint.position_start()]), DIGITS) + 0.0
        for joint in skeleton.joints
    }
    surface = {"contact": SURFACE, "contact_margin": kind.margin}
    data: dict[str, Any] = {
        "name": skeleton.model.path.stem,
        "model": "",
        "floating_base": names.name_of(skeleton.root),
        **_pose("floating_base_pose", R_RB, base_origin(skeleton, limbs, R_RB)),
        **(surface if kind.contact == SURFACE else {}),
        "feet": feet,
        "lock": {name: angle for name, angle in angles.items() if name not in kept},
        "nominal_posture": {name: angle for name, angle in angles.items() if name in kept},
        "limits": ANY_LIMITS,
    }
    source = (
        "collision shapes" if soles[0].from_shapes else "drawings, for want of collision shapes"
    )
    lines = [
        f"torso: {skeleton.root.name()}" + ("" if np.allclose(R_RB, np.eye(3)) else ", turned"),
        f"legs: {' '.join(feet[0]['leg_joints'])} and {' '.join(feet[1]['leg_joints'])}",
        f"arms: {' '.join(arms) or 'none that move'}",
        f"soles, from {source}: {soles[0].toe[0] - soles[0].heel[0]:.3f} m long, "
        f"{soles[0].width:.3f} m wide",
        _said(kind, feet[0]),
    ]
    if assumed:
        lines.append(f"could not know {assumed}")
    return data, soles, lines


def _said(kind: ContactKind, foot: dict[str, Any]) -> str:
    """Return the line on how feet touch."""
    if kind.contact != SURFACE:
        return f"contact: a line, with no ankle roll: {kind.why_line}"
    heel, toe = foot["contact_points"]
    size = f"{toe[0] - heel[0]:.3f} m long, {foot['contact_width']:.3f} m wide"
    return (
        f"contact: a surface {size}, the largest rectangle in the sole; its cones leave "
        f"{1e3 * kind.margin:.1f} mm at each edge"
    )


def _feet(
    skeleton: Skeleton, legs: list[list[Joint]], soles: list[Sole], kind: ContactKind
) -> list[dict[str, Any]]:
    """Return the description of both feet, equally long and wide."""
    names, feet = skeleton.names, []
    for side, leg, sole, kept in zip(SIDES, legs, soles, kind.legs, strict=True):
        frame = {"frame": names.name_of(leg[-1].child_body()), **_pose("pose", sole.R_BF)}
        joints = [names.name_of(leg[i]) for i in kept]
        feet.append({"name": side, **frame, "contact_points": [], "leg_joints": joints})
    lines = [np.array([sole.heel, sole.toe]) for sole in soles]
    if kind.contact == SURFACE:
        lines = [sole.corners * [1.0, 0.0, 1.0] for sole in soles]
        for line, sole in zip(lines, soles, strict=True):
            line[:, 1] = sole.corners[:, 1].mean()
    lengths = _alike(skeleton, "length", [float(toe[0] - heel[0]) for heel, toe in lines])
    length = round(0.5 * sum(lengths), DIGITS)  # of both, whatever the ends are rounded to
    for line, foot in zip(lines, feet, strict=True):
        heel = line.mean(axis=0) - [0.5 * length, 0.0, 0.0]
        x, y, z = (round(float(each), DIGITS) + 0.0 for each in heel)
        foot["contact_points"] = [[x, y, z], [round(x + length, DIGITS) + 0.0, y, z]]
    if kind.contact == SURFACE:
        widths = _alike(skeleton, "width", [sole.flat_width for sole in soles])
        for foot in feet:
            foot["contact_width"] = round(min(widths), DIGITS)
    return feet


def _alike(skeleton: Skeleton, what: str, sizes: list[float]) -> list[float]:
    """Return a size of both feet, which must hardly differ."""
    if abs(sizes[0] - sizes[1]) > UNEQUAL * max(sizes):
        raise skeleton.refuse([round(size, 3) for size in sizes], f"feet differ in {what}")
    return sizes


def _pose(entry: str, R: Array, p: Array = _ORIGIN) -> dict[str, Any]:
    """Return an entry for a rotation and an origin, or none for neither."""
    pose = {}
    if not np.allclose(R, np.eye(3), rtol=0.0, atol=1e-9):
        rpy = RollPitchYaw(RotationMatrix.ProjectToRotationMatrix(R)).vector()
        pose["rpy"] = [round(float(angle), 9) + 0.0 for angle in rpy]
    if p.any():
        pose["xyz"] = [round(float(x), DIGITS) + 0.0 for x in p]
    return {entry: pose} if pose else {}


def _paired(data: dict[str, Any], path: Path, lines: list[str]) -> Humanoid:
    """Return the robot, with other joints locked as well until each has its mirror image."""
    while True:
        try:
            return Humanoid(_description(data, path), checked=False)
        except ModelError as error:
            legs = {name for foot in data["feet"] for name in foot["leg_joints"]}
            if error.entry != "mirror" or error.value in legs:
                raise
            data["lock"][str(error.value)] = 0.0
            lines.append(f"{error.value} has no mirror image: locked")


def _say_stance(lines: list[str], humanoid: Humanoid, reach: Reach, width: float) -> None:
    """Add lines on mass, posture, limits and torques."""
    lines.append(
        f"mass {humanoid.mass:.1f} kg, centre of mass {reach.height:.3f} m high, "
        f"{reach.straight:.3f} m with straight legs, {reach.lowest:.3f} m at the lowest"
    )
    if reach.room != (1.0, 1.0):
        stride, lift = (f"{share:.0%}" for share in reach.room)
        rest = f"nearly straight; of a walk by default {stride} of a step, {lift} of a swing"
        lines.append(f"joints turn little: shorter steps and lower swings, legs {rest}")
    plant, feet = humanoid.plant, humanoid.description.feet
    joints = [humanoid.names.joint(name).index() for foot in feet for name in foot.leg_joints]
    moved = plant.GetBodiesKinematicallyAffectedBy(joints)
    legs = sum(plant.get_body(index).default_mass() for index in moved) / humanoid.mass
    if legs > HEAVY_LEGS:
        lines.append(f"legs have {legs:.0%} of the mass: their swing may tip so light a torso over")
    torques = abs(standing_torques(humanoid, humanoid.q_nominal)[1][0])
    limits = humanoid.effort_limits[humanoid.leg_joints[0]]
    for name, torque, limit in zip(feet[0].leg_joints, torques, limits, strict=True):
        share = torque / limit
        lines.append(f"on one leg {name} holds {torque:.1f} of {limit:.0f} N m ({share:.0%})")
