"""The legs as chains of revolute joints, read from the model, and where their links are.

A leg is a chain of n revolute joints from the torso to a contact of n coordinates: a line has
five, position (3) and direction (2: pitch and yaw), a sole its roll as well. A joint's rotation
by q is ``turn = B0 + sin q B1 + (1 - cos q) B2``; beside it stand its axis and its place, both
constant in the frame before. Everything is expressed in the torso frame B, at its origin.
"""

import math
from typing import NamedTuple

import numpy as np

from drake_linefoot.axes import WRENCH
from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.rotation import skew
from drake_linefoot.robot.chains import foot_in_link, revolute_chain
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.mirror import ALONG, joint_lines
from drake_linefoot.types import Array


class Legs(NamedTuple):
    """What a chain is made of, for n legs of j joints.

    Attributes:
        turns: B0, B1, B2 of each joint, shape (n, 3, j, 3, 3).
        axes: of each joint in the frame before, unit vectors, shape (n, j, 3).
        places: of each joint in the frame before [m], shape (n, j, 3).
        ends: middle of the contact in the last frame [m], shape (n, 3).
        lower: joint limits [rad], shape (n, j).
        upper: joint limits [rad], shape (n, j).
        zeros: j of them, a number that is known when a function is compiled.
    """

    turns: Array
    axes: Array
    places: Array
    ends: Array
    lower: Array
    upper: Array
    zeros: tuple[float, ...]


class Links(NamedTuple):
    """The j links of one leg in the torso frame; the last has the axes of the foot F.

    Attributes:
        R: orientations, that of the torso before them, shape (j + 1, 3, 3).
        axes: of the joints that carry them, shape (j, 3).
        origins: [m], that of the torso before them, shape (j + 1, 3).
    """

    R: Array
    axes: Array
    origins: Array


class Roles(NamedTuple):
    """Which joints of a leg bend it ahead and turn its foot, by their axes: places in its chain.

    Attributes:
        knee: the last but one that turns about y.
        ankle: the last one.
        roll: that of the ankle that turns a sole about x; -1 for a leg with a line.
    """

    knee: int
    ankle: int
    roll: int


def leg_roles(humanoid: Humanoid) -> Roles:
    """Find knee and ankle joints of a leg by their axes, with all joints at 0.

    Raises:
        ModelError: they are not there, or not in the same places of both legs.
    """
    d, found = humanoid.description, []
    for foot in d.feet:
        _, axes = joint_lines(humanoid.names, humanoid.base.body_frame(), foot.leg_joints)
        across = np.flatnonzero(np.abs(axes[:, 1]) > ALONG)[-2:].tolist()
        along = np.flatnonzero(np.abs(axes[:, 0]) > ALONG)[-1:].tolist()
        found.append(across + (along if len(foot.leg_joints) == len(WRENCH) else [-1]))
    knee, *_, roll = found[0] if len(found[0]) == len(Roles._fields) else (0, -2)
    if found[0] != found[1] or roll < -1 or 0 <= roll < knee:
        allowed = "both legs need a knee and an ankle that turn about y, in the same places"
        allowed += ", and for a sole an ankle that turns about x"
        raise d.refuse("feet[1].leg_joints", list(d.feet[1].leg_joints), allowed)
    return Roles(*found[0])


def contact_from_ankle(humanoid: Humanoid, side: int) -> Array:
    """Return where the middle of a contact is from the ankle that pitches it, axes of F [m], (3,).

    With all joints at 0: the ankle that rolls a sole may be between them.

    Raises:
        ModelError: see `leg_roles`.
    """
    joint = humanoid.description.feet[side].leg_joints[leg_roles(humanoid).ankle]
    ankle, context = humanoid.names.joint(joint), humanoid.plant.CreateDefaultContext()
    X_FA = ankle.frame_on_child().CalcPose(context, humanoid.foot_frames[side])
    p_AC: Array = humanoid.p_FC[side] - X_FA.translation()
    return p_AC


def read_legs(humanoid: Humanoid) -> Legs:
    """Read both legs, left before right, from the model.

    Raises:
        ModelError: the joints of a leg do not form a chain of revolute joints, as many as its
            contact has coordinates.
    """
    n = humanoid.contact.size
    turns, axes, places = np.zeros((2, 3, n, 3, 3)), np.zeros((2, n, 3)), np.zeros((2, n, 3))
    ends = np.zeros((2, 3))
    for side in range(2):
        for i, (X, joint) in enumerate(revolute_chain(humanoid, side)):
            R, axis = X.rotation().matrix(), np.asarray(joint.revolute_axis())
            S = skew(axis)
            turns[side, :, i] = R, R @ S, R @ S @ S
            axes[side, i] = R @ axis
            places[side, i] = X.translation()
        X_LF = foot_in_link(humanoid, side)
        turns[side, :, -1] = turns[side, :, -1] @ X_LF.rotation().matrix()
        ends[side] = humanoid.p_FC[side] + X_LF.rotation().matrix().T @ X_LF.translation()
    limits = humanoid.position_lower, humanoid.position_upper
    lower, upper = (limit[humanoid.leg_joints] for limit in limits)
    return Legs(turns, axes, places, ends, lower, upper, (0.0,) * n)


@compiled
def new_links(legs: Legs) -> Links:
    """Return memory for the links of a leg."""
    n = len(legs.zeros)
    links = Links(np.zeros((n + 1, 3, 3)), np.zeros((n, 3)), np.zeros((n + 1, 3)))
    for i in range(3):
        links.R[0, i, i] = 1.0
    return links


@compiled
def chain(legs: Legs, leg: int, q: Array, links: Links) -> None:
    """Write the links of a leg at joint angles `q` [rad], shape (j,)."""
    # Loops, not `@`: see `leg_kinematics`.
    turns, axes, places = legs.turns, legs.axes, legs.places
    R, a, o = links.R, links.axes, links.origins
    for i in range(len(legs.zeros)):
        sine, versine = math.sin(q[i]), 1.0 - math.cos(q[i])
        for r in range(3):
            x, y, z = R[i, r, 0], R[i, r, 1], R[i, r, 2]
            a[i, r] = x * axes[leg, i, 0] + y * axes[leg, i, 1] + z * axes[leg, i, 2]
            out = x * places[leg, i, 0] + y * places[leg, i, 1] + z * places[leg, i, 2]
            o[i + 1, r] = o[i, r] + out
            R[i + 1, r] = 0.0
        for k in range(3):
            for c in range(3):
                turn = turns[leg, 0, i, k, c] + sine * turns[leg, 1, i, k, c]
                turn += versine * turns[leg, 2, i, k, c]
                for r in range(3):
                    R[i + 1, r, c] += R[i, r, k] * turn
