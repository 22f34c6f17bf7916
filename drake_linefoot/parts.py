"""Parts of signals that are made alike, or that several signals have."""

from typing import Final

from drake_linefoot.axes import FEET, PLACE, SPATIAL, XYZ
from drake_linefoot.layout import Axis, Part

KNOTS: Final = 14  # intervals of the MPC, unless told otherwise
AT_KNOTS, PHASES, PIECES = "knots + 1", "knots + 12", "knots + 14"  # with room for a late plan
ACCELERATION: Final = ("rad/s^2", "m/s^2")  # angular over linear
FOREVER: Final = 1e9  # [s] the end of what has none


def whole(meaning: str, *axes: Axis) -> Part:
    """Return a part of flags, counts or an index."""
    return Part(meaning, "-", *axes, is_whole=True)


def in_world(meaning: str, unit: str, *axes: Axis) -> Part:
    """Return a part with the axes of W."""
    return Part(meaning, unit, *axes, frame="W")


def wrenches(meaning: str, *axes: Axis) -> Part:
    """Return a part that is a wrench of each foot."""
    return Part(meaning, ("N", "N m"), *axes, FEET, "nw", groups=(3,), frame="W, C")


def spatial(meaning: str, units: tuple[str, str]) -> Part:
    """Return a part that is angular over linear, with the axes of W."""
    return Part(meaning, units, SPATIAL, groups=(3, 3), frame="W")


EXTERNAL = spatial("what else acts on the robot and lasts, about the CoM", ("N m", "N"))
SLOPE = in_world("rise of the ground per metre", "-", ("x", "y"))
OF_GROUND = "rise per metre of the ground under each foot, or where it lands"
FRICTION = Part("of the ground, at most: what feet that slid have told, 1 before", "-")
TIMES = Part("knots", "s", AT_KNOTS)
LINES = in_world("contact lines", "m", "knots", FEET, XYZ)
FRAMES = in_world("contact frames", "-", "knots", FEET, XYZ, XYZ)
COMING = whole("how many footholds there are")
FOOTHOLDS = Part("coming footholds, in order", "m, rad", AT_KNOTS, PLACE)
STATUS = whole("how the last program was solved: a `Solved`")
ACTIVE_ROWS = whole("rows of the cones that are active, where it says so")
