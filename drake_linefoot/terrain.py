"""What is known of the ground: convex patches in plan, each a plane that may be a little off."""

from typing import Annotated, Final, NamedTuple

import numpy as np

from drake_linefoot.constants import PATCH_CORNERS
from drake_linefoot.layout import Layout, Part, opener
from drake_linefoot.parts import in_world, whole
from drake_linefoot.types import Array

PATCHES: Final = 24  # at most, those near the robot
CORNERS: Final = PATCH_CORNERS


class Terrain(NamedTuple):
    """The patches of ground near the robot, on which feet may stand.

    A patch without corners has no edge, and its plane is the one that feet feel: ground of which
    nothing is known is one such patch.
    """

    number: Annotated[float, whole("of patches, 1 to 24")]
    sides: Annotated[Array, whole("how many corners each has; 0: it has no edge", PATCHES)]
    corners: Annotated[
        Array, in_world("counter-clockwise from above", "m", PATCHES, CORNERS, ("x", "y"))
    ]
    plane: Annotated[
        Array, Part("height at 0, rise along x and y", ("m", "-", "-"), PATCHES, 3, frame="W")
    ]
    sigma: Annotated[Array, Part("how far off edges and height may be", "m", PATCHES)]


TERRAIN = Layout(Terrain, {})
open_terrain = opener(Terrain)


def felt_ground() -> Array:
    """Return the vector of ground of which nothing is known but what feet feel."""
    vector = np.zeros(TERRAIN.size)
    vector[TERRAIN.place("number")] = 1.0
    return vector
