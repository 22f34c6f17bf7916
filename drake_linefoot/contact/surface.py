"""The contact of a sole that has a width: a rectangle that presses with its four corners.

A wrench ``w = [f_x, f_y, f_z, tau_y, tau_z, tau_x]`` at the middle C of a rectangle of half length
X and half width Y is one of forces at its corners, each in its friction pyramid, if and only if it
meets the 16 rows of [28], with the pyramid (9) of the line, here all in the foot frame:

    |f_x|, |f_y| <= mu f_z,  |tau_y| <= X f_z,  |tau_x| <= Y f_z,
     tau_z <= mu (X + Y) f_z - |Y f_x + mu tau_x| - |X f_y + mu tau_y|,
    -tau_z <= mu (X + Y) f_z - |Y f_x - mu tau_x| - |X f_y - mu tau_y|.

With Y = 0 they say (18) and tau_x = 0. A program with Y near 0 is badly scaled, so a foot that is
nearly a line is a `LineContact`.
"""

from dataclasses import dataclass
from itertools import product
from typing import ClassVar

import numpy as np

from drake_linefoot.constants import STANDARD_GRAVITY
from drake_linefoot.contact.contacts import Contact
from drake_linefoot.contact.wrench_cone import BOTH, NEITHER, check_positive
from drake_linefoot.types import Array, Indices

SIGNS = (1.0, -1.0)


def surface_cone(mu: float, half_length: float, half_width: float) -> Array:
    """Return the wrench cone of a rectangle, [28]; all rows are needed where it has a width.

    Args:
        mu: friction coefficient [-].
        half_length: X, half its length along x of the foot [m].
        half_width: Y, half its width [m]; 0 for a line, whose rows of tau_x say that it is 0.

    Returns:
        Rows of ``W w <= 0`` in w = [f_x, f_y, f_z, tau_y, tau_z, tau_x], shape (16, 6).

    Raises:
        ValueError: `mu` or `half_length` is not positive.
    """
    check_positive(mu, half_length)
    X, Y, b = half_length, half_width, mu * (half_length + half_width)
    of_force = [[s, 0.0, -mu, 0.0, 0.0, 0.0] for s in SIGNS]
    of_force += [[0.0, s, -mu, 0.0, 0.0, 0.0] for s in SIGNS]
    of_centre = [[0.0, 0.0, -X, s, 0.0, 0.0] for s in SIGNS]
    of_centre += [[0.0, 0.0, -Y, 0.0, 0.0, s] for s in SIGNS]
    of_turn = [
        [a * Y, c * X, -b, c * turn * mu, turn, a * turn * mu]
        for turn, a, c in product(SIGNS, repeat=3)
    ]
    return np.array(of_force + of_centre + of_turn)


@dataclass(frozen=True)
class SurfaceContact(Contact):
    """A rectangle, which turns about no axis as long as its centre of pressure is inside, [28].

    Each row has the friction of the whole foot. On one edge a foot still resists a turn, by its
    width, and how much is no linear function of its wrench and of friction at heel and toe.

    Attributes:
        half_width: Y, half its width along y of the foot [m].
    """

    half_width: float
    size: ClassVar[int] = 6
    ends: ClassVar[Indices] = np.array([BOTH] * 4 + [NEITHER] * 4 + [BOTH] * 8)

    def cone(self, mu: float) -> Array:
        """Return `surface_cone` with every row of the unit of a force, shape (16, 6)."""
        check_positive(mu, self.half_width, "half width")
        cone = surface_cone(mu, self.half_length, self.half_width)
        tau_y, tau_z, tau_x = self._arms()
        for rows, arm in ((slice(4, 6), tau_y), (slice(6, 8), tau_x), (slice(8, 16), tau_z)):
            cone[rows] /= arm
        return cone

    def units(self, mass: float) -> Array:
        """Return m g for forces, and that times what each torque is bounded by, (6,)."""
        return mass * STANDARD_GRAVITY * np.array([1.0, 1.0, 1.0, *self._arms()])

    def pressure_weights(self, weight: float) -> Array:
        """Return weights of tau_y and tau_x, which are f_z times the centre of pressure, (6,)."""
        X, Y = self.half_length, self.half_width
        return weight * np.array([0.0, 0.0, 0.0, X**-2, 0.0, Y**-2])

    def scaled(self) -> "SurfaceContact":
        """Return the contact whose cone is that of scaled wrenches: a rectangle of its shape."""
        return _ScaledSurface(self.half_length, self.half_width)

    def _arms(self) -> tuple[float, float, float]:
        """Return the greatest arms of tau_y, tau_z and tau_x [m]."""
        return self.half_length, self.half_length + self.half_width, self.half_width


class _ScaledSurface(SurfaceContact):
    """A rectangle whose torques are given in units of `SurfaceContact`."""

    def cone(self, mu: float) -> Array:
        """Return rows for scaled wrenches, shape (16, 6)."""
        return super().cone(mu) * self.units(1.0 / STANDARD_GRAVITY)
