"""Physical constants, in one place."""

from typing import Final

import numpy as np

from drake_linefoot.types import Array

PATCH_CORNERS: Final = 8  # of a patch of known ground, at most
STANDARD_GRAVITY: Final = 9.81  # [m/s^2], Drake's default
GRAVITY: Final[Array] = np.array([0.0, 0.0, -STANDARD_GRAVITY])  # in W [m/s^2]
