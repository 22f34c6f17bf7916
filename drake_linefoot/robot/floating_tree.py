"""Mass and centre of mass of what floats: what a model fixes to the world is no part of a robot."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from pydrake.multibody.plant import MultibodyPlant

from drake_linefoot.types import Array

if TYPE_CHECKING:
    from pydrake.systems.framework import Context


class FloatingTree:
    """The bodies of a robot's own plant that are not fixed to the world.

    Attributes:
        mass: of them [kg].
    """

    def __init__(self, plant: MultibodyPlant) -> None:
        """Read what is fixed to the world in a finalized plant, as a table or a static ground."""
        self._plant, context = plant, plant.CreateDefaultContext()
        fixed = plant.GetBodiesWeldedTo(plant.world_body())[1:]
        masses = np.array([body.default_mass() for body in fixed])
        places = [
            body.EvalPoseInWorld(context) @ body.CalcCenterOfMassInBodyFrame(context)
            for body in fixed
        ]
        self._total: float = plant.CalcTotalMass(context)
        self._fixed = float(masses.sum())
        self._moment: Array = masses @ np.reshape(places, (-1, 3))  # of what is fixed [kg m]
        self.mass = self._total - self._fixed

    def com(self, context: Context) -> Array:
        """Return the centre of mass in W [m], shape (3,)."""
        p: Array = self._plant.CalcCenterOfMassPositionInWorld(context)
        return (self._total * p - self._moment) / self.mass if self._fixed else p

    def com_velocity(self, context: Context) -> Array:
        """Return the velocity of the centre of mass in W [m/s], shape (3,)."""
        v: Array = self._plant.CalcCenterOfMassTranslationalVelocityInWorld(context)
        return v * (self._total / self.mass) if self._fixed else v
