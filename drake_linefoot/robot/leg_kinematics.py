"""Leg kinematics for many configurations at once: where the contact lines are, and back.

A leg of five joints places the middle of its contact line (3) and the line's direction
(2: pitch and yaw). The chain is read from the model, so any such leg works.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.tree import RevoluteJoint

from drake_linefoot.errors import ModelError
from drake_linefoot.math.linear import solve
from drake_linefoot.math.so3 import cross_rows, skew
from drake_linefoot.robot.humanoid import Humanoid

Array = NDArray[np.float64]

_LINE_ROWS = 5
_STANDSTILL = 1e-3  # [-] of the residual: a step that changes it by less brings nothing


class LegChain:
    """The chain from the torso to one contact line.

    Attributes:
        lower, upper: joint limits [rad], shape (n,).
    """

    def __init__(self, humanoid: Humanoid, side: int) -> None:
        """Read fixed transforms and axes of one leg (0 left, 1 right) from the model.

        Raises:
            ModelError: the joints do not form a chain of five revolute joints.
        """
        description = humanoid.description
        # What a joint's rotation by q is made of: turn = B0 + sin q B1 + (1 - cos q) B2. The
        # constant columns beside it are its axis and where it stands, in the frame before.
        self._turns = np.zeros((3, _LINE_ROWS, 3, 3))
        self._axes = np.zeros((_LINE_ROWS, 3))
        self._places = np.zeros((_LINE_ROWS, 3))
        for i, joint in enumerate(_revolute_chain(humanoid, side)):
            X = joint.frame_on_parent().GetFixedPoseInBodyFrame()
            R, axis = X.rotation().matrix(), np.asarray(joint.revolute_axis())
            S = skew(axis)
            self._turns[:, i] = R, R @ S, R @ S @ S
            self._axes[i] = R @ axis
            self._places[i] = X.translation()
        self._end = humanoid.p_FC[side]
        names = description.feet[side].leg_joints
        index = [description.actuated_joints.index(name) for name in names]
        self.lower = humanoid.position_lower[index]
        self.upper = humanoid.position_upper[index]

    def forward(self, q: Array) -> tuple[Array, Array, Array]:
        """Return pose and Jacobian of the contact line in the torso frame.

        Args:
            q: joint angles [rad], shape (..., 5).

        Returns:
            (p_BC, R_BF, J): shapes (..., 3), (..., 3, 3), (..., 6, 5); J maps joint rates to
            the velocity of C (first three) and the angular velocity of F, both in B.
        """
        B0, B1, B2 = self._turns
        sine, versine = np.sin(q)[..., None, None], (1.0 - np.cos(q))[..., None, None]
        steps = np.empty((*q.shape, 3, 5))  # turn, axis and place of each joint
        steps[..., :3] = B0 + sine * B1 + versine * B2
        steps[..., 3] = self._axes
        steps[..., 4] = self._places
        motion = np.empty((*q.shape, 3, 5))  # the same in the torso
        motion[..., 0, :, :] = steps[..., 0, :, :]
        for i in range(1, _LINE_ROWS):
            before, now = motion[..., i - 1, :, :], motion[..., i, :, :]
            np.matmul(before[..., :3], steps[..., i, :, :], out=now)
            now[..., 4] += before[..., 4]
        R = motion[..., -1, :, :3]
        p_BC = motion[..., -1, :, 4] + (R @ self._end[..., None])[..., 0]
        axes = motion[..., 3]
        J = np.empty((*q.shape[:-1], 6, _LINE_ROWS))
        levers = p_BC[..., None, :] - motion[..., 4]
        J[..., :3, :] = np.swapaxes(cross_rows(axes, levers), -1, -2)
        J[..., 3:, :] = np.swapaxes(axes, -1, -2)
        return p_BC, R, J

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
        q = np.minimum(np.maximum(q, self.lower), self.upper)
        best = q
        smallest = before = np.full(q.shape[:-1], np.inf)
        for step in range(iterations + 1):
            p, R, J = self.forward(q)
            error = _line_error(p, R, p_BC, d_B)
            residual = np.sqrt(np.einsum("...i,...i->...", error, error))
            moving = np.abs(residual - before) > _STANDSTILL * residual
            going_on, before = (residual >= tolerance) & moving, residual
            best = np.where((residual < smallest)[..., None], q, best)
            smallest = np.minimum(smallest, residual)
            if step == iterations or not going_on.any():
                break
            q = q + _damped_step(_line_jacobian(R, J), error)
            q = np.minimum(np.maximum(q, self.lower), self.upper)
        return best, smallest

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
        _, R, J = self.forward(q)
        return _damped_step(_line_jacobian(R, J), _line_rows(R, v_BC, w_BF))


class LegPair(LegChain):
    """Both legs at once: every array has left and right as its first dimension, then K rows."""

    def __init__(self, humanoid: Humanoid) -> None:
        """Read both legs from the model.

        Raises:
            ModelError: the joints of a leg do not form a chain of five revolute joints.
        """
        legs = [LegChain(humanoid, side) for side in (0, 1)]
        self._turns = np.stack([leg._turns for leg in legs], axis=1)[:, :, None]
        self._axes, self._places, self._end, self.lower, self.upper = (
            np.stack([getattr(leg, name) for leg in legs])[:, None]
            for name in ("_axes", "_places", "_end", "lower", "upper")
        )


def _revolute_chain(humanoid: Humanoid, side: int) -> list[RevoluteJoint]:
    """Return the joints of a leg; raise ModelError when they are not what `LegChain` needs."""
    plant, description = humanoid.plant, humanoid.description
    foot = description.feet[side]
    entry = f"feet[{side}].leg_joints"
    if len(foot.leg_joints) != _LINE_ROWS:
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


def _line_rows(R: Array, linear: Array, angular: Array) -> Array:
    """Return a vector and the parts of another across the line, shape (..., 5)."""
    across = (np.swapaxes(R[..., 1:], -1, -2) @ angular[..., None])[..., 0]
    return np.concatenate([linear, across], axis=-1)


def _line_jacobian(R: Array, J: Array) -> Array:
    """Return the rows of (51) in the torso frame, shape (..., 5, 5)."""
    across = np.swapaxes(R[..., 1:], -1, -2) @ J[..., 3:, :]
    return np.concatenate([J[..., :3, :], across], axis=-2)


def _line_error(p: Array, R: Array, p_d: Array, d_d: Array) -> Array:
    """Return the five errors of a line, shape (..., 5)."""
    return _line_rows(R, p_d - p, _turn(R[..., 0], R[..., 2], d_d))


def _turn(x: Array, z: Array, d: Array) -> Array:
    """Return the rotation that takes the line x to d, of length sin below a right angle.

    Above, its length is the angle, since the sine would vanish again for a line that points
    backwards; one that points straight backwards turns about z.
    """
    turn = cross_rows(x, d)
    cosine = np.einsum("...i,...i->...", x, d)
    behind = cosine < 0.0
    if behind.any():
        sine = np.linalg.norm(turn[behind], axis=1)
        axis = np.where((sine > 1e-9)[:, None], turn[behind], z[behind])
        angle = np.arctan2(sine, cosine[behind])
        turn[behind] = axis * (angle / np.linalg.norm(axis, axis=1))[:, None]
    return turn


def _damped_step(E: Array, error: Array, damping: float = 1e-8) -> Array:
    """Solve ``E step = error``, damped so that a straight knee gives a finite step."""
    Et = np.swapaxes(E, -1, -2)
    normal = Et @ E
    normal[..., range(_LINE_ROWS), range(_LINE_ROWS)] += damping
    return solve(normal, Et @ error[..., None])[..., 0]
