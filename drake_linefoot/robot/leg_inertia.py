"""Inertia and angular momentum of the robot for many configurations of its legs at once.

Drake says once what every link weighs, and for the arms as they are held now; the legs are
moved by `inertia_kernels`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.tree import BodyIndex

from drake_linefoot.robot import inertia_kernels
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.inertia_kernels import Masses
from drake_linefoot.robot.leg_kinematics import LegPair

Array = NDArray[np.float64]


class LegInertia:
    """The robot as a torso and two moving legs, with arms that hold still."""

    def __init__(self, humanoid: Humanoid, legs: LegPair) -> None:
        """Read from the model what hangs on the torso and on each link of the legs."""
        self._humanoid, self._legs = humanoid, legs.legs
        self._context = humanoid.plant.CreateDefaultContext()
        plant, description = humanoid.plant, humanoid.description
        names = [name for foot in description.feet for name in foot.leg_joints]
        frames = [humanoid.base, *(plant.GetJointByName(name).child_body() for name in names)]
        self._frames = [body.body_frame() for body in frames]
        self._groups = _hanging_on(humanoid, [body.index() for body in frames])
        plant.SetPositions(self._context, humanoid.q_nominal)
        rows = [self._rigid_body(i) for i in range(len(frames))]
        self._masses = Masses(*(np.array(values) for values in zip(*rows, strict=True)))
        arms = {plant.GetJointByName(name).child_body().index() for name in description.arm_joints}
        self._with_arms = [i for i, group in enumerate(self._groups) if arms & set(group)]

    def _rigid_body(self, i: int) -> tuple[float, Array, Array]:
        """Return mass, CoM and inertia of group `i`, with the joints as they are in the context."""
        plant, context = self._humanoid.plant, self._context
        spatial = plant.CalcSpatialInertia(context, self._frames[i], self._groups[i])
        mass: float = spatial.get_mass()
        if mass == 0.0:
            return 0.0, np.zeros(3), np.zeros((3, 3))
        com = spatial.get_com()
        central = spatial.Shift(com).CalcRotationalInertia()
        return mass, com, central.CopyToFullMatrix3()

    def __call__(self, q: Array, angles: Array, rates: Array, Omega: Array) -> tuple[Array, Array]:
        """Return locked inertia and angular momentum about the CoM, both in the torso frame.

        Args:
            q: present positions, of which the arms' count, shape (nq,).
            angles: of the legs [rad], shape (2, K, 5).
            rates: their rates [rad/s], shape (2, K, 5).
            Omega: angular velocity of the torso in B [rad/s], shape (K, 3).

        Returns:
            (I_B, L_B): [kg m^2] shape (K, 3, 3), [kg m^2/s] shape (K, 3).
        """
        masses = self._masses
        if self._with_arms:
            self._humanoid.plant.SetPositions(self._context, q)
        for i in self._with_arms:
            masses.mass[i], masses.com[i], masses.inertia[i] = self._rigid_body(i)
        return inertia_kernels.inertia_and_momentum(self._legs, masses, angles, rates, Omega)


def _hanging_on(humanoid: Humanoid, roots: list[BodyIndex]) -> list[list[BodyIndex]]:
    """Return for each of some bodies itself and what hangs on it and on none further out."""
    plant = humanoid.plant
    parents = {}
    for index in plant.GetJointIndices():
        joint = plant.get_joint(index)
        parents[joint.child_body().index()] = joint.parent_body().index()
    groups: list[list[BodyIndex]] = [[] for _ in roots]
    for index in plant.GetBodyIndices(humanoid.base.model_instance()):
        at = index
        while at not in roots:
            at = parents[at]
        groups[roots.index(at)].append(index)
    return groups
