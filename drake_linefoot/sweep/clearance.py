"""How far the two legs of a recorded run are from each other."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.robot.humanoid import Humanoid, load_humanoid

Array = NDArray[np.float64]

LIMB_RADIUS = 0.02  # [m] of shank and foot as capsules: half the width of the pad, its README
_PARALLEL = 1e-9  # [-] of the squared lengths; below it two segments count as parallel

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
    legs = leg_segments(humanoid, q)
    gaps = [segment_distance(legs[:, 0, i], legs[:, 1, j]) for i in (0, 1) for j in (0, 1)]
    clearance: Array = np.min(gaps, axis=0) - 2.0 * LIMB_RADIUS
    return clearance


def leg_segments(humanoid: Humanoid, q: Array) -> Array:
    """Return the axes of the capsules of a leg, foot before shank.

    Args:
        humanoid: the robot.
        q: configurations, shape (n, nq).

    Returns:
        Both ends of each axis in W [m], shape (n, 2 legs, 2, 2 ends, 3).
    """
    plant = humanoid.plant
    context = plant.CreateDefaultContext()
    up = np.array([0.0, 0.0, LIMB_RADIUS])
    joints = [
        [plant.GetJointByName(name).frame_on_child() for name in foot.leg_joints[-2:]]
        for foot in humanoid.description.feet
    ]
    out = np.empty((len(q), 2, 2, 2, 3))
    for i, row in enumerate(q):
        plant.SetPositions(context, row)
        for side, foot in enumerate(humanoid.description.feet):
            X_WF = humanoid.foot_frames[side].CalcPoseInWorld(context)
            out[i, side, 0] = (X_WF @ (foot.contact_points + up).T).T
            out[i, side, 1] = [f.CalcPoseInWorld(context).translation() for f in joints[side]]
    return out


def segment_distance(a: Array, b: Array) -> Array:
    """Return the distance between line segments.

    Args:
        a: ends of the first one of each pair [m], shape (n, 2, 3).
        b: of the second one, shape (n, 2, 3).

    Returns:
        Shape (n,) [m].
    """
    d1, d2, r = a[:, 1] - a[:, 0], b[:, 1] - b[:, 0], a[:, 0] - b[:, 0]
    A, E, F = _dot(d1, d1), _dot(d2, d2), _dot(d2, r)
    B, C = _dot(d1, d2), _dot(d1, r)
    room = A * E - B * B
    skew = room > _PARALLEL * A * E
    s = np.where(skew, np.clip((B * F - C * E) / np.where(skew, room, 1.0), 0.0, 1.0), 0.0)
    t = np.clip((B * s + F) / E, 0.0, 1.0)  # the point of b nearest to that of a
    s = np.clip((B * t - C) / A, 0.0, 1.0)  # and back: exact where t was clipped
    gap = r + s[:, None] * d1 - t[:, None] * d2
    distance: Array = np.sqrt(_dot(gap, gap))
    return distance


def _dot(u: Array, v: Array) -> Array:
    product: Array = np.einsum("ij,ij->i", u, v)
    return product
