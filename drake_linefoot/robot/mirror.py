"""Which joint is the mirror image of which, and with what sign: from places and axes."""

from collections.abc import Sequence

import numpy as np
from pydrake.multibody.tree import Frame, PrismaticJoint

from drake_linefoot.robot.description import HumanoidDescription
from drake_linefoot.robot.names import Names
from drake_linefoot.types import Array

PLANE = np.array([1.0, -1.0, 1.0])  # of a vector mirrored in y = 0
AXIAL = -PLANE  # of an axis of rotation
ALIKE = 0.9  # [-] least cosine between an axis and the mirror image of its partner's
UNLIKE = 0.01  # [rad] by which limits of left and right may differ
ALONG = 0.7  # [-] least part of an axis along what it is said to turn about
APART = 0.05  # [-] of the robot's size: how far a joint may be from its mirror image


def joint_lines(robot: Names, base: Frame, names: Sequence[str]) -> tuple[Array, Array]:
    """Return where n joints are and their axes, in frame B with all joints at 0.

    Returns:
        (p, a): [m] and unit vectors, shapes (n, 3).
    """
    plant = robot.plant
    context, q = plant.CreateDefaultContext(), np.zeros(plant.num_positions())
    q[0] = 1.0
    plant.SetPositions(context, q)
    places, axes = [], []
    for name in names:
        joint = robot.joint(name)
        X = joint.frame_on_parent().CalcPose(context, base)
        places.append(X.translation())
        slides = isinstance(joint, PrismaticJoint)
        axis = joint.translation_axis() if slides else joint.revolute_axis()
        axes.append(X.rotation() @ axis)
    return np.array(places), np.array(axes)


def derived_mirror(
    d: HumanoidDescription, robot: Names, base: Frame
) -> dict[str, tuple[str, float]]:
    """Return the partner of every joint and the factor on its angle.

    Joints of the legs are partners in their order, the others by their places and axes; a joint in
    the plane y = 0 may be its own.

    Returns:
        Left joint -> (right joint, 1 or -1).

    Raises:
        ModelError: a joint has no partner.
    """
    names = d.actuated_joints
    p, a = joint_lines(robot, base, names)
    size = float(np.ptp(p, axis=0).max())
    partners = dict(zip(*(foot.leg_joints for foot in d.feet), strict=True))
    left = [i for i, name in enumerate(names) if name not in {*partners, *partners.values()}]
    while left:
        i = left[0]
        gaps = np.linalg.norm(p[left] - PLANE * p[i], axis=1) / size
        cosines = np.abs(a[left] @ (AXIAL * a[i]))
        cost = np.where(cosines > ALIKE, gaps + 1.0 - cosines, np.inf)
        j = left[int(np.argmin(cost))]
        if not cost.min() < APART:
            allowed = "must name its mirror image, or it must be locked: none was found"
            raise d.refuse("mirror", names[i], allowed)
        first, second = (i, j) if p[i, 1] >= p[j, 1] else (j, i)
        partners[names[first]] = names[second]
        left = [k for k in left if k not in (i, j)]
    axis = dict(zip(names, a, strict=True))
    return {
        one: (partners[one], mirror_sign(axis[one], axis[partners[one]]))
        for one in sorted(partners, key=names.index)
    }


def unlike_limits(
    d: HumanoidDescription,
    axes: Array,
    lower: Array,
    upper: Array,
    legs: Sequence[str],
) -> tuple[str, ...]:
    """Return pairs of joints whose limits are no mirror images, a line each.

    A difference is harmless where both joints can do most of what either can.

    Args:
        d: of the robot, with its `mirror`.
        axes: of the joints, shape (na, 3).
        lower: limits of position [rad], shape (na,).
        upper: likewise.
        legs: names of their joints.

    Raises:
        ModelError: limits of a leg are as with a lost sign, or have less than half in common.
    """
    lines, names = [], list(d.actuated_joints)
    for left, (right, _) in d.mirror.items():
        i, j = names.index(str(left)), names.index(right)
        own, other = np.array([lower[i], upper[i]]), np.array([lower[j], upper[j]])
        image = other if mirror_sign(axes[i], axes[j]) > 0.0 else -other[::-1]
        if i == j or np.abs(own - image).max() <= UNLIKE:
            continue
        ranges = " and ".join(f"[{low:g}, {high:g}]" for low, high in (own, other))
        found = f"limits are no mirror images: {ranges}"
        shared = min(own[1], image[1]) - max(own[0], image[0])
        lost_sign = np.abs(own + image[::-1]).max() <= UNLIKE
        if left in legs and (lost_sign or shared < 0.5 * min(np.ptp(own), np.ptp(other))):
            raise d.refuse("model", f"{left} and {right}", f"{found}; is a sign lost?")
        lines.append(f"{left} and {right}: {found}")
    return tuple(lines)


def mirror_sign(left: Array, right: Array) -> float:
    """Return the factor on a joint's angle that mirrors it, from both axes, shapes (3,)."""
    return 1.0 if right @ (AXIAL * left) >= 0.0 else -1.0
