"""Leg kinematics for many configurations at once: where the contact lines are, and back.

A leg of five joints places the middle of its contact line (3) and the line's direction
(2: pitch and yaw). The chain is read from the model, so any such leg works.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.tree import RevoluteJoint

from drake_linefoot.errors import ModelError
from drake_linefoot.math.so3 import skew
from drake_linefoot.robot import leg_kernels
from drake_linefoot.robot.chain_kernels import JOINTS, Legs
from drake_linefoot.robot.humanoid import Humanoid

Array = NDArray[np.float64]


class LegChain:
    """The chain from the torso to one contact line.

    Attributes:
        legs: what the kernels know of the leg.
        lower, upper: joint limits [rad], shape (5,); of both legs (2, 5).
    """

    def __init__(self, humanoid: Humanoid, side: int) -> None:
        """Read fixed transforms and axes of one leg (0 left, 1 right) from the model.

        Raises:
            ModelError: the joints do not form a chain of five revolute joints.
        """
        description = humanoid.description
        turns, axes, places = (
            np.zeros((3, JOINTS, 3, 3)),
            np.zeros((JOINTS, 3)),
            np.zeros((JOINTS, 3)),
        )
        for i, joint in enumerate(_revolute_chain(humanoid, side)):
            X = joint.frame_on_parent().GetFixedPoseInBodyFrame()
            R, axis = X.rotation().matrix(), np.asarray(joint.revolute_axis())
            S = skew(axis)
            turns[:, i] = R, R @ S, R @ S @ S
            axes[i] = R @ axis
            places[i] = X.translation()
        names = description.feet[side].leg_joints
        index = [description.actuated_joints.index(name) for name in names]
        self.lower = humanoid.position_lower[index]
        self.upper = humanoid.position_upper[index]
        rows = (turns, axes, places, humanoid.p_FC[side], self.lower, self.upper)
        self.legs = Legs(*(np.array([row]) for row in rows))

    def forward(self, q: Array) -> tuple[Array, Array, Array]:
        """Return pose and Jacobian of the contact line in the torso frame.

        Args:
            q: joint angles [rad], shape (..., 5).

        Returns:
            (p_BC, R_BF, J): shapes (..., 3), (..., 3, 3), (..., 6, 5); J maps joint rates to
            the velocity of C (first three) and the angular velocity of F, both in B.
        """
        leading = q.shape[:-1]
        p_BC, R_BF, J = leg_kernels.forward(self.legs, self._by_leg(q))
        return (
            p_BC.reshape(*leading, 3),
            R_BF.reshape(*leading, 3, 3),
            J.reshape(*leading, 6, JOINTS),
        )

    def inverse(
        self, p_BC: Array, d_B: Array, q: Array, iterations: int = 8, tolerance: float = 1e-6
    ) -> tuple[Array, Array]:
        """Return joint angles that place the contact line (damped Newton, all at once).

        A line out of reach gets the angles of the nearest one the iteration finds; the
        residual says how far away that is. It ends when no line moves any more.

        Args:
            p_BC: middle of the line in the torso frame [m], shape (..., 3).
            d_B: direction of the line in the torso frame, unit vectors, shape (..., 3).
            q: first guess [rad], shape (..., 5).
            iterations: most Newton steps.
            tolerance: residual at which to stop [m, rad].

        Returns:
            (q, residual): shapes (..., 5) and (...).
        """
        wanted = (self._by_leg(p_BC), self._by_leg(d_B), self._by_leg(q))
        best, residual = leg_kernels.inverse(self.legs, *wanted, iterations, tolerance)
        return best.reshape(q.shape), residual.reshape(q.shape[:-1])

    def rates(self, q: Array, v_BC: Array, w_BF: Array) -> Array:
        """Return joint rates that move the contact line.

        Args:
            q: joint angles [rad], shape (..., 5).
            v_BC: velocity of C relative to and expressed in the torso [m/s], shape (..., 3).
            w_BF: angular velocity of the line, likewise [rad/s], shape (..., 3); its part
                along the line does not count.

        Returns:
            Joint rates [rad/s], shape (..., 5).
        """
        motion = (self._by_leg(q), self._by_leg(v_BC), self._by_leg(w_BF))
        return leg_kernels.rates(self.legs, *motion).reshape(q.shape)

    def _by_leg(self, a: Array) -> Array:
        """Return vectors by leg and configuration, as the kernels take them."""
        return np.ascontiguousarray(a).reshape(len(self.legs.turns), -1, a.shape[-1])


class LegPair(LegChain):
    """Both legs at once: every array has left and right as its first dimension, then K rows."""

    def __init__(self, humanoid: Humanoid) -> None:
        """Read both legs from the model.

        Raises:
            ModelError: the joints of a leg do not form a chain of five revolute joints.
        """
        pair = [LegChain(humanoid, side) for side in (0, 1)]
        rows = zip(*(leg.legs for leg in pair), strict=True)
        self.legs = Legs(*(np.concatenate(values) for values in rows))
        self.lower, self.upper = self.legs.lower, self.legs.upper


def _revolute_chain(humanoid: Humanoid, side: int) -> list[RevoluteJoint]:
    """Return the joints of a leg; raise ModelError when they are not what `LegChain` needs."""
    plant, description = humanoid.plant, humanoid.description
    foot = description.feet[side]
    entry = f"feet[{side}].leg_joints"
    if len(foot.leg_joints) != JOINTS:
        allowed = "must name five joints: position of the line and its pitch and yaw"
        raise ModelError(description.file, entry, list(foot.leg_joints), allowed)
    parent = plant.GetBodyByName(description.floating_base)
    joints = []
    for name in foot.leg_joints:
        joint = plant.GetJointByName(name)
        identity = joint.frame_on_child().GetFixedPoseInBodyFrame().IsNearlyIdentity(1e-12)
        chained = joint.parent_body().index() == parent.index() and identity
        if not isinstance(joint, RevoluteJoint) or not chained:
            raise ModelError(description.file, entry, name, "is not next in a revolute chain")
        joints.append(joint)
        parent = joint.child_body()
    if parent.name() != foot.frame:
        raise ModelError(description.file, entry, foot.frame, "the chain must end at the foot")
    return joints
