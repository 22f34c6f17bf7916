"""Whether feet touch along a line or with their soles, and which joints of a leg that takes."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pydrake.multibody.tree import Joint

from drake_linefoot.constants import STANDARD_GRAVITY
from drake_linefoot.contact.contacts import LineContact
from drake_linefoot.contact.surface import SurfaceContact
from drake_linefoot.lab.new_robot.skeleton import Skeleton
from drake_linefoot.lab.new_robot.soles import Sole
from drake_linefoot.lab.new_robot.topology import axis_in, joints_to_keep
from drake_linefoot.robot.description import LINE, SURFACE
from drake_linefoot.robot.floating_tree import FloatingTree

MARGIN = 0.15  # [-] of half the width that cones leave at each edge of a sole
LEAST_MARGIN = 0.002  # [m] of it: contact points are hardly known better
NARROW = 0.05  # [-] of half the length: a sole that presses less far aside is nearly a line


@dataclass(frozen=True)
class ContactKind:
    """How both feet touch the ground.

    Attributes:
        contact: `LINE` or `SURFACE`.
        legs: joints that are kept, of both legs: indices into each.
        margin: what contact cones leave at each edge [m]; 0 for a line.
        why_line: what a sole lacks; empty for a surface.
    """

    contact: str
    legs: list[list[int]]
    margin: float
    why_line: str


def contact_kind(
    skeleton: Skeleton,
    legs: Sequence[Sequence[Joint]],
    soles: Sequence[Sole],
    asked: str | None,
) -> ContactKind:
    """Return how feet touch: with soles where legs and soles are made for it, or as was asked for.

    A sole with a width is worth an ankle roll only where the ground's force can move aside: a foot
    that is nearly a line is a line.

    Args:
        skeleton: of the robot.
        legs: joints of both from hip to foot.
        soles: of both feet.
        asked: `LINE` or `SURFACE`; None: as the robot is made.

    Raises:
        ModelError: the legs move no line, or a surface is asked for and legs or soles are not made
            for it.
    """
    margin = round(max(MARGIN * 0.5 * min(sole.flat_width for sole in soles), LEAST_MARGIN), 4)
    why = "asked for"
    if asked != LINE:
        kept = _kept(skeleton, legs, soles, SurfaceContact.size)
        why = _lacks(skeleton, legs, soles, kept, margin)
        if not why:
            return ContactKind(SURFACE, kept, margin, "")
        if asked == SURFACE:
            raise skeleton.refuse(SURFACE, f"feet cannot be surfaces: {why}")
    kept = _kept(skeleton, legs, soles, LineContact.size)
    if not all(kept):
        names = [skeleton.names.name_of(joint) for joint in legs[kept.index([])]]
        raise skeleton.refuse(names, "no five of these joints move a line foot in all its ways")
    return ContactKind(LINE, kept, 0.0, why)


def _kept(
    skeleton: Skeleton, legs: Sequence[Sequence[Joint]], soles: Sequence[Sole], count: int
) -> list[list[int]]:
    """Return which joints of each leg move a contact in its coordinates; none where none do."""
    both = zip(legs, soles, strict=True)
    return [
        joints_to_keep(skeleton, leg, leg[-1].child_body(), sole.R_BF, count) for leg, sole in both
    ]


def _lacks(
    skeleton: Skeleton,
    legs: Sequence[Sequence[Joint]],
    soles: Sequence[Sole],
    kept: Sequence[Sequence[int]],
    margin: float,
) -> str:
    """Return what keeps feet from being surfaces, or nothing.

    The ground's force can move aside as far as the sole goes, less the margin, and as far as the
    ankle's roll holds the robot's weight that far from its middle.
    """
    count = len(legs[0])
    if count < SurfaceContact.size:
        return f"a leg has {count} joints, a sole needs six (hip 3, knee, ankle pitch and roll)"
    if not all(kept):
        return "no six joints of a leg move a sole in all its ways, the last two in pitch and roll"
    weight = FloatingTree(skeleton.plant).mass * STANDARD_GRAVITY
    efforts = skeleton.efforts()
    for leg, sole, joints in zip(legs, soles, kept, strict=True):
        need = NARROW * 0.5 * sole.flat_length
        room = 0.5 * sole.flat_width - margin
        if room < need:
            wide = f"{1e3 * sole.flat_width:.0f} mm wide"
            return f"soles are {wide}, of which {1e3 * max(room, 0.0):.1f} mm a side can be used"
        body = leg[-1].child_body()
        last = [leg[k] for k in joints[-2:]]
        roll = last[int(np.argmax([abs(axis_in(skeleton, j, body, sole.R_BF)[0]) for j in last]))]
        name = skeleton.names.name_of(roll)
        if efforts.get(name, 0.0) < need * weight:
            holds = f"{name} has {efforts.get(name, 0.0):.3g} N m"
            return f"{holds}, which holds the weight no {1e3 * need:.1f} mm aside"
    return ""
