"""Contacts as data: how many numbers a foot's wrench has, and which wrenches the ground gives.

A wrench at the middle C of a contact is ``[f_x, f_y, f_z]`` in W and then ``tau_y, tau_z, tau_x``
in C. A point has the first three of them, a line five, a surface all six: every kind is a prefix,
and so are the rows of its Jacobian. Estimator, MPC and whole-body controller take size, rows and
units from here; who adds a contact writes a class with these, and gives it to `load_humanoid`.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from drake_linefoot.constants import STANDARD_GRAVITY
from drake_linefoot.contact.wrench_cone import BOTH, HEEL, TOE, force_cone
from drake_linefoot.types import Array, Indices


@dataclass(frozen=True)
class Contact(ABC):
    """A contact of a foot with the ground.

    Attributes:
        half_length: X, half its length along x of the foot [m].
        size: how many numbers its wrench has.
        ends: whose friction each row of the cone has: `HEEL`, `TOE`, or `BOTH`: the greater one;
            `NEITHER` where friction does not enter.
    """

    half_length: float
    size: ClassVar[int]
    ends: ClassVar[Indices]

    @abstractmethod
    def cone(self, mu: float) -> Array:
        """Return rows ``W w <= 0`` in the frame of the ground, of the unit of a force.

        In a row that has friction, the normal force and its moments enter multiplied by it, columns
        f_z, tau_y and tau_x, and nothing else does.

        Args:
            mu: friction coefficient [-].

        Returns:
            Shape (r, size).

        Raises:
            ValueError: `mu` or a length is not positive.
        """

    def units(self, mass: float) -> Array:
        """Return units of a wrench in scaled programs: m g for forces, m g X for torques, (size,).

        Args:
            mass: of the robot [kg].
        """
        weight = mass * STANDARD_GRAVITY
        return np.array([weight] * 3 + [weight * self.half_length] * (self.size - 3))

    def pressure_weights(self, weight: float) -> Array:
        """Return weights of a wrench that keep the centre of pressure off the edge, (size,).

        A point has no edge; of a line the weight of a torque is one already.

        Args:
            weight: of a normal force that is at the edge [1/N^2].
        """
        return np.zeros(self.size)

    def scaled(self) -> "Contact":
        """Return the contact with X for the unit of length: its cone is that of scaled wrenches."""
        return replace(self, half_length=1.0)


@dataclass(frozen=True)
class LineContact(Contact):
    """A line from heel to toe: it carries no moment about itself, (13)."""

    size: ClassVar[int] = 5
    ends: ClassVar[Indices] = np.array([BOTH, BOTH, TOE, HEEL, HEEL, TOE])

    def cone(self, mu: float) -> Array:
        """Return the simplified line-contact wrench cone (18), shape (6, 5)."""
        return force_cone(mu, self.half_length)
