"""Where a robot's feet touch the ground: from their shapes to contact lines."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pydrake.multibody.tree import Joint
from scipy.spatial import ConvexHull, QhullError

from drake_linefoot.contact.contacts import LineContact
from drake_linefoot.lab.new_robot.skeleton import Skeleton
from drake_linefoot.lab.new_robot.topology import Limbs, snapped
from drake_linefoot.robot.shapes import Cloud, cloud_of
from drake_linefoot.types import Array

TILTED = 0.6  # [rad] most angle of a sole against the torso's level
LEVEL = 0.02  # [rad] below which it is taken to be level
POINTED = 0.04  # [-] of the leg: a shorter foot is a point
CUTS = 121  # across a sole, at which a rectangle in it may end
ALONG_EDGE = 1e-9  # [-] of an edge of a sole: one that bounds nothing aside
TOE_LONGER = 1.25  # [-] of the heel: how much further the toe must reach to be known as such


@dataclass(frozen=True)
class Sole:
    """A foot's contact line, the largest rectangle in its sole, and what was measured.

    Attributes:
        R_BF: axes of the foot F in its body: x along the line, z up; shape (3, 3).
        heel, toe: ends of the line in F, whose origin is the body's [m], shapes (3,).
        width: of the sole [m].
        corners: of the rectangle in F, right heel and left toe [m], shape (2, 3).
        from_shapes: whether the model has collision shapes there; otherwise its drawings.
    """

    R_BF: Array
    heel: Array
    toe: Array
    width: float
    corners: Array
    from_shapes: bool

    @property
    def flat_length(self) -> float:
        """Of the rectangle [m]."""
        return float(self.corners[1, 0] - self.corners[0, 0])

    @property
    def flat_width(self) -> float:
        """Of the rectangle [m]."""
        return float(self.corners[1, 1] - self.corners[0, 1])


def foot_cloud(skeleton: Skeleton, leg: Sequence[Joint]) -> tuple[Cloud, bool]:
    """Return what a foot consists of, in the frame of its last link, and whether of shapes.

    To the foot belongs all that is behind the fifth joint.

    Raises:
        ModelError: it has neither collision shapes nor drawings whose form can be read.
    """
    last = leg[-1].child_body()
    plant, links = skeleton.plant, [joint.child_body() for joint in leg[LineContact.size - 1 :]]
    parts = [body for link in links for body in plant.GetBodiesWeldedTo(link)]
    poses = {b: b.body_frame().CalcPose(skeleton.context, last.body_frame()) for b in parts}
    found = cloud_of(plant, skeleton.scene_graph, poses)
    if found is None:
        reason = "the foot has neither collision shapes nor meshes, so its sole is unknown"
        raise skeleton.refuse(last.name(), reason)
    return found


def forward_of(
    skeleton: Skeleton, limbs: Limbs, clouds: Sequence[Cloud]
) -> tuple[Array, str | None]:
    """Return which way is ahead in the root, and what was assumed when feet do not show it.

    Toes reach further from the last joint that lies across than heels do.
    """
    forward = np.cross(limbs.across, limbs.up)
    toes, heels = 0.0, 0.0
    for leg, cloud in zip(limbs.legs, clouds, strict=True):
        body = leg[-1].child_body().body_frame()
        X_RB = body.CalcPose(skeleton.context, skeleton.root.body_frame())
        ankle = next((j for j in reversed(leg) if _lies_along(skeleton, j, limbs.across)), leg[-1])
        at = float(skeleton.place(ankle.frame_on_child()) @ forward)
        inside = X_RB.rotation().matrix().T @ forward
        offset = float(X_RB.translation() @ forward)
        toes += cloud.reach(inside) + offset - at
        heels += cloud.reach(-inside) - offset + at
    if max(toes, heels) > TOE_LONGER * min(toes, heels):
        return (forward if toes > heels else -forward), None
    sign = 1.0 if forward[np.argmax(np.abs(forward))] >= 0.0 else -1.0
    return sign * forward, "which way is ahead: feet are as long behind the ankle; took the root's"


def _lies_along(skeleton: Skeleton, joint: Joint, direction: Array) -> bool:
    X = joint.frame_on_child().CalcPose(skeleton.context, skeleton.root.body_frame())
    return abs(float((X.rotation() @ joint.revolute_axis()) @ direction)) > 0.9


def find_sole(
    skeleton: Skeleton, leg: Sequence[Joint], cloud: Cloud, R_RB: Array, from_shapes: bool
) -> Sole:
    """Return the contact line of a foot, along the middle of its sole, and the rectangle in it.

    The cloud of the foot is in its body's frame; R_RB has the torso's axes in the root, ahead,
    left and up, shape (3, 3).

    Raises:
        ModelError: the foot is a point.
    """
    body = leg[-1].child_body()
    X = body.body_frame().CalcPose(skeleton.context, skeleton.root.body_frame())
    up = _sole_normal(cloud, X.rotation().matrix().T @ R_RB[:, 2])
    ahead = X.rotation().matrix().T @ R_RB[:, 0]
    x = snapped(_unit(ahead - (ahead @ up) * up))
    R_BF = np.column_stack([x, np.cross(up, x), up])
    p = cloud.p @ R_BF
    touching = Cloud(p, cloud.radius).sole().p
    heel, toe = float(touching[:, 0].min()), float(touching[:, 0].max())
    long = float(np.linalg.norm(X.translation() - skeleton.place(leg[0].frame_on_parent())))
    if toe - heel < POINTED * long:
        reason = f"the foot is a point: its sole is {1e3 * (toe - heel):.0f} mm long"
        reason += "; on points a robot cannot stand still"
        raise skeleton.refuse(body.name(), reason)
    sides = touching[:, 1].min(), touching[:, 1].max()
    y, z = 0.5 * sum(sides), float((p[:, 2] - cloud.radius).min())
    line = np.array([[heel, y, z], [toe, y, z]])
    corners = np.column_stack([inscribed(touching[:, :2]), [z, z]])
    return Sole(R_BF, line[0], line[1], float(sides[1] - sides[0]), corners, from_shapes)


def inscribed(points: Array) -> Array:
    """Return the largest rectangle along x and y in the hull of points [m].

    Args:
        points: [m], shape (n, 2).

    Returns:
        Its lowest and its highest corner, shape (2, 2); without a width where the hull has none.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    try:
        edges = ConvexHull(points).equations  # n.T p + b <= 0
    except (QhullError, ValueError):  # on a line, or too few points
        middle = 0.5 * (low + high)[1]
        return np.array([[low[0], middle], [high[0], middle]])
    x = np.linspace(low[0], high[0], CUTS)
    right, left = (
        -(edges[way, :1] * x + edges[way, 2:]) / edges[way, 1:2]
        for way in (edges[:, 1] < -ALONG_EDGE, edges[:, 1] > ALONG_EDGE)
    )
    right, left = right.max(axis=0), left.min(axis=0)  # the hull's sides
    bottom, top = np.maximum.outer(right, right), np.minimum.outer(left, left)
    area = np.subtract.outer(-x, -x) * np.maximum(top - bottom, 0.0)  # of heel i and toe j
    i, j = np.unravel_index(np.argmax(area), area.shape)
    return np.array([[x[i], bottom[i, j]], [x[j], top[i, j]]])


def _sole_normal(cloud: Cloud, up: Array) -> Array:
    """Return the direction away from the sole: of the largest flat part of a foot's underside."""
    try:
        hull = ConvexHull(cloud.p)
    except (QhullError, ValueError):  # flat, or too few points
        return snapped(up)
    corners = cloud.p[hull.simplices]
    areas = 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    normals = -hull.equations[:, :3]
    below = normals @ up > np.cos(TILTED)
    if not below.any():
        return snapped(up)
    alike = normals[below] @ normals[below].T > np.cos(LEVEL)
    flat = int(np.argmax(alike @ areas[below]))
    normal = _unit((normals[below] * areas[below, None])[alike[flat]].sum(axis=0))
    return snapped(up) if normal @ up > np.cos(2.0 * LEVEL) else normal


def _unit(vector: Array) -> Array:
    return vector / np.linalg.norm(vector)
