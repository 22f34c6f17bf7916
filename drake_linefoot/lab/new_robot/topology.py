"""What is what in a model: the torso and its axes, the two legs, the joints between."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations, takewhile

import numpy as np
from pydrake.multibody.tree import (
    Joint,
    RevoluteJoint,
    RigidBody,
)

from drake_linefoot.contact.contacts import LineContact
from drake_linefoot.lab.new_robot.skeleton import Skeleton
from drake_linefoot.robot.chains import least_mobility
from drake_linefoot.robot.floating_tree import FloatingTree
from drake_linefoot.types import Array

SNAP = 0.02  # [rad] by which an axis may be off one of the torso's to be taken for it
EQUAL = 0.03  # [-] of their depth: how far the ends of both legs may differ
OTHERS = 0.9  # [-] of their depth: what reaches deeper is another leg
SAMPLES, BEND = 8, 0.4  # configurations in which legs are tried; [rad] most angle in them
GOOD = 0.4  # [-] of the best: how far from singular a choice of joints must be
ALONG = 0.9  # [-] least cosine between an axis of an ankle and one of its foot's
ARM_JOINTS = 4  # of an arm that are kept: shoulder and elbow
AHEAD, ASIDE, BELOW, ABOVE = 0.5, 0.01, -0.4, 1.5  # [-] of the legs, of a root from the hips
MOBILE = 1e-3  # [-] of least mobility: what moves less is singular
LIGHT = 0.003  # [-] of the mass: what moves less is locked


@dataclass(frozen=True)
class Limbs:
    """What legs and arms are.

    Attributes:
        up: the torso's vertical in the root, shape (3,).
        across: unit vector from one foot to the other, shape (3,).
        middle: between the feet in the root [m], shape (3,).
        legs: joints of both, from hip to foot, in no order of sides.
        others: all other joints.
    """

    up: Array
    across: Array
    middle: Array
    legs: tuple[list[Joint], list[Joint]]
    others: list[Joint]


def find_limbs(skeleton: Skeleton) -> Limbs:
    """Return the two chains that reach lowest as legs.

    Vertical is the axis of the root along which two chains reach equally far and no other does; z
    is tried first.

    Raises:
        ModelError: there are no two such chains, or more of them, or they have too few joints.
    """
    inner = {joint.parent_body().index() for joint in skeleton.joints}
    ends = []
    for joint in skeleton.joints:
        group = skeleton.plant.GetBodiesWeldedTo(joint.child_body())
        if not inner & {body.index() for body in group}:
            ends.append((skeleton.chain(joint.child_body()), group))
    for up in [sign * row for row in np.eye(3)[::-1] for sign in (1.0, -1.0)]:
        found = _lowest_two(skeleton, ends, up)
        if found is not None:
            break
    else:
        chains = ", ".join(sorted(chain[-1].name() for chain, _ in ends)[:6])
        raise skeleton.refuse(chains, "no two limbs reach lowest, as legs do")
    first, second = found
    shared = [a for a, b in zip(first, second, strict=False) if a.index() == b.index()]
    legs = first[len(shared) :], second[len(shared) :]
    for leg in legs:
        names = [joint.name() for joint in leg]
        if len(leg) < LineContact.size:
            allowed = f"a leg has {len(leg)} joints; a line foot needs five (hip 3, knee, ankle)"
            raise skeleton.refuse(names, allowed)
        if not all(isinstance(joint, RevoluteJoint) for joint in leg):
            raise skeleton.refuse(names, "legs must have revolute joints")
    if len(legs[0]) != len(legs[1]):
        counts = [len(leg) for leg in legs]
        raise skeleton.refuse(counts, "both legs must have as many joints")
    left, right = (skeleton.place(leg[-1].frame_on_child()) for leg in legs)
    gap = left - right
    gap -= (gap @ up) * up
    if np.linalg.norm(gap) == 0.0:
        raise skeleton.refuse([leg[-1].name() for leg in legs], "both feet are in one place")
    taken = {joint.index() for joint in [*shared, *legs[0], *legs[1]]}
    others = [joint for joint in skeleton.joints if joint.index() not in taken]
    across = snapped(gap / np.linalg.norm(gap))
    return Limbs(up, across, 0.5 * (left + right), legs, others)


def _lowest_two(
    skeleton: Skeleton, ends: Sequence[tuple[list[Joint], list[RigidBody]]], up: Array
) -> tuple[list[Joint], list[Joint]] | None:
    """Return the two chains that reach deepest below the CoM, if they do so alike and alone.

    Of the chains that reach as deep as the deepest one, the other leg is that which parts from it
    nearest to the root: toes of one foot part behind it.
    """
    depths = [
        max((skeleton.com - skeleton.place(body.body_frame())) @ up for body in group)
        for _, group in ends
    ]
    order = np.argsort(depths)[::-1]
    first, deep = int(order[0]), max(depths)
    ids = [[joint.index() for joint in chain] for chain, _ in ends]

    def apart(k: int) -> int:
        """Return how many joints the shorter of a chain and the first has of its own."""
        common = len(shared_beginning(ids[first], ids[k]))
        return min(len(ids[first]), len(ids[k])) - common

    alike = [int(k) for k in order[1:] if deep - depths[k] < EQUAL * deep and apart(int(k)) > 0]
    if not alike or deep <= 0.0:
        return None
    second = max(alike, key=apart)
    common = set(shared_beginning(ids[first], ids[second]))
    legs = {*ids[first], *ids[second]} - common
    rest = [depths[k] for k in range(len(ends)) if not legs & set(ids[k])]
    if max(rest, default=-np.inf) > OTHERS * deep:
        return None
    return ends[first][0], ends[second][0]


def shared_beginning(first: Sequence[object], second: Sequence[object]) -> list[object]:
    """Return what two chains have in common before they part."""
    both = takewhile(lambda pair: pair[0] == pair[1], zip(first, second, strict=False))
    return [one for one, _ in both]


def base_origin(skeleton: Skeleton, limbs: Limbs, R_RB: Array) -> Array:
    """Return the origin of B in the root: its own, or the middle of the hips where that is far off.

    A controller of the torso asks where it is; a frame on the floor or to one side is no torso's.

    Args:
        skeleton: of the robot.
        limbs: of the robot.
        R_RB: axes of B in the root, ahead, left and up, shape (3, 3).

    Returns:
        [m], shape (3,).
    """
    hips = np.mean([skeleton.place(leg[0].frame_on_parent()) for leg in limbs.legs], axis=0)
    long = float((hips - limbs.middle) @ R_RB[:, 2])
    ahead, aside, above = (-hips @ R_RB / long).tolist()  # of the root's origin
    near = abs(ahead) < AHEAD and abs(aside) < ASIDE and BELOW < above < ABOVE
    return np.zeros(3) if near else hips


def snapped(direction: Array) -> Array:
    """Return the axis of the frame that a unit vector nearly is, or the vector, shape (3,)."""
    axis = np.round(direction)
    return axis if np.linalg.norm(direction - axis) < SNAP else direction


def joints_to_keep(
    skeleton: Skeleton, leg: Sequence[Joint], body: RigidBody, R_BF: Array, count: int
) -> list[int]:
    """Return which joints of a leg move its contact well: indices into `leg`.

    Of the choices after which the contact can be moved in all its coordinates, and the last axis
    lies across its line, or the last two across and along its sole, the one that locks joints
    nearest to the foot, as a toe's, or for a line an ankle's roll.

    Args:
        skeleton: of the robot.
        leg: joints from hip to foot.
        body: of the foot.
        R_BF: axes of the foot in it, shape (3, 3).
        count: how many joints: as many as the contact has coordinates.

    Returns:
        None of them where no choice does.
    """
    plant, base, foot = skeleton.plant, skeleton.root.body_frame(), body.body_frame()
    columns = np.array([joint.velocity_start() for joint in leg])
    rest = plant.GetPositions(skeleton.context)
    random = np.random.default_rng(0)
    hip = skeleton.place(leg[0].frame_on_parent())
    tries: dict[tuple[int, ...], float] = {}
    for kept in combinations(range(len(leg)), count):
        ankle = np.abs([axis_in(skeleton, leg[k], body, R_BF) for k in kept[-2:]])
        wanted = ankle[1, 1] if count == LineContact.size else ankle[:, :2].max(axis=0).min()
        if wanted < ALONG:
            continue
        context = plant.CreateDefaultContext()
        scores = []
        for _ in range(SAMPLES):
            q = rest.copy()
            for k in kept:
                joint = leg[k]
                low, high = joint.position_lower_limits(), joint.position_upper_limits()
                at = q[joint.position_start()] + random.uniform(-BEND, BEND)
                q[joint.position_start()] = np.clip(at, low, high)[0]
            plant.SetPositions(context, q)
            scores.append(
                least_mobility(plant, context, base, foot, np.zeros(3), columns[[*kept]], hip, R_BF)
            )
        tries[kept] = float(np.mean(scores))
    best = max(tries.values(), default=0.0)
    if best < MOBILE:
        return []
    good = [kept for kept, score in tries.items() if score > GOOD * best]
    return list(min(good, key=sum))


def axis_in(skeleton: Skeleton, joint: Joint, body: RigidBody, R_BF: Array) -> Array:
    """Return the axis of a joint at rest in axes of a body's, R_BF, shape (3,)."""
    R = joint.frame_on_child().CalcPose(skeleton.context, body.body_frame()).rotation().matrix()
    axis: Array = R_BF.T @ R @ joint.revolute_axis()
    return axis


def arms_to_keep(skeleton: Skeleton, limbs: Limbs, forward: Array) -> list[str]:
    """Return the other joints that go on moving: shoulders and elbows, in pairs.

    Joints in the middle, such as waist and neck, and those behind the elbow are locked, and those
    that move next to nothing or have no limits.
    """
    plant, context = skeleton.plant, skeleton.context
    total, left = FloatingTree(plant).mass, np.cross(limbs.up, forward)

    def aside(joint: Joint) -> float:
        """Return how far a joint is from the middle between the feet."""
        return abs(float((skeleton.place(joint.frame_on_child()) - limbs.middle) @ left))

    size = max(map(aside, skeleton.joints))
    efforts = skeleton.efforts()
    kept: list[str] = []
    for joint in sorted(limbs.others, key=lambda j: len(skeleton.chain(j.child_body()))):
        beyond = plant.GetBodiesKinematicallyAffectedBy([joint.index()])
        mass = sum(plant.get_body(index).get_mass(context) for index in beyond)
        chain = [skeleton.names.name_of(j) for j in skeleton.chain(joint.child_body())]
        name = skeleton.names.name_of(joint)
        limits = [*joint.position_lower_limits(), *joint.position_upper_limits()]
        limits += [*joint.velocity_upper_limits()]
        if (
            isinstance(joint, RevoluteJoint)
            and aside(joint) > 0.05 * size
            and mass > LIGHT * total
            and sum(name in kept for name in chain) < ARM_JOINTS
            and np.all(np.isfinite(limits))
            and 0.0 < efforts.get(name, 0.0) < np.inf
            and name not in skeleton.model.mimics
        ):
            kept.append(name)
    return kept
