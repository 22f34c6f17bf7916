"""The contact of a point: three numbers, no torque."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from drake_linefoot.contact.contacts import Contact
from drake_linefoot.contact.wrench_cone import BOTH, point_cone
from drake_linefoot.types import Array, Indices


@dataclass(frozen=True)
class PointContact(Contact):
    """A point: it carries a force within its friction pyramid, (9).

    Cones, MPC and whole-body controller take it. No robot stands still on two of them, so no
    description has it.
    """

    half_length: float = 0.0
    size: ClassVar[int] = 3
    ends: ClassVar[Indices] = np.full(4, BOTH)

    def cone(self, mu: float) -> Array:
        """Return `point_cone`, shape (4, 3)."""
        return point_cone(mu)
