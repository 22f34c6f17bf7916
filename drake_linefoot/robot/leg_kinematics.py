"""Leg kinematics for many configurations at once: where the contact lines are, and back.

A leg of five joints places the middle of its contact line (3) and the line's direction
(2: pitch and yaw). The chain is read from the model, so any such leg works.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.tree import RevoluteJoint

from drake_linefoot.errors import ModelError
from drake_linefoot.math import so3
from drake_linefoot.math.linear import solve
from drake_linefoot.robot.humanoid import Humanoid

Array = NDArray[np.float64]

_LINE_ROWS = 5


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
        plant, description = humanoid.plant, humanoid.description
        foot = description.feet[side]
        entry = f"feet[{side}].leg_joints"
        if len(foot.leg_joints) != _LINE_ROWS:
            allowed = "must name five joints: position of the line and its pitch and yaw"
            raise ModelError(description.file, entry, list(foot.leg_joints), allowed)
        parent = plant.GetBodyByName(description.floating_base)
        self._R: list[Array] = []  # from the previous joint's frame to this joint's
        self._p: list[Array] = []
        self._axis: list[Array] = []
        for name in foot.leg_joints:
            joint = plant.GetJointByName(name)
            identity = joint.frame_on_child().GetFixedPoseInBodyFrame().IsNearlyIdentity(1e-12)
            chained = joint.parent_body().index() == parent.index() and identity
            if not isinstance(joint, RevoluteJoint) or not chained:
                raise ModelError(description.file, entry, name, "is not next in a revolute chain")
            X = joint.frame_on_parent().GetFixedPoseInBodyFrame()
            self._R.append(X.rotation().matrix())
            self._p.append(X.translation())
            self._axis.append(np.asarray(joint.revolute_axis()))
            parent = joint.child_body()
        if parent.name() != foot.frame:
            raise ModelError(description.file, entry, foot.frame, "the chain must end at the foot")
        self._p_FC = humanoid.p_FC[side]
        index = [description.actuated_joints.index(name) for name in foot.leg_joints]
        self.lower = humanoid.position_lower[index]
        self.upper = humanoid.position_upper[index]

    def forward(self, q: Array) -> tuple[Array, Array, Array]:
        """Return pose and Jacobian of the contact line in the torso frame.

        Args:
            q: joint angles [rad], shape (K, 5).

        Returns:
            (p_BC, R_BF, J): shapes (K, 3), (K, 3, 3), (K, 6, 5); J maps joint rates to
            the velocity of C (first three) and the angular velocity of F, both in B.
        """
        K, n = q.shape
        R = np.broadcast_to(np.eye(3), (K, 3, 3))
        p = np.zeros((K, 3))
        origins = np.empty((K, n, 3))
        axes = np.empty((K, n, 3))
        for i in range(n):
            p = p + R @ self._p[i]
            R = R @ self._R[i]
            origins[:, i] = p
            axes[:, i] = R @ self._axis[i]
            R = R @ so3.exp(q[:, i, None] * self._axis[i])
        p_BC = p + R @ self._p_FC
        J = np.empty((K, 6, n))
        J[:, :3] = np.swapaxes(np.cross(axes, p_BC[:, None] - origins), 1, 2)
        J[:, 3:] = np.swapaxes(axes, 1, 2)
        return p_BC, R, J

    def inverse(
        self, p_BC: Array, d_B: Array, q: Array, iterations: int = 8, tolerance: float = 1e-6
    ) -> tuple[Array, Array]:
        """Return joint angles that place the contact line (damped Newton, all at once).

        A line out of reach gets the angles of the nearest one the iteration finds; the
        residual says how far away that is.

        Args:
            p_BC: middle of the line in the torso frame [m], shape (K, 3).
            d_B: direction of the line in the torso frame, unit vectors, shape (K, 3).
            q: first guess [rad], shape (K, 5).
            iterations: most Newton steps.
            tolerance: residual at which to stop [m, rad].

        Returns:
            (q, residual): shapes (K, 5) and (K,).
        """
        q = np.clip(q, self.lower, self.upper)
        best, smallest = q, np.full(len(q), np.inf)
        for step in range(iterations + 1):
            p, R, J = self.forward(q)
            error, E = _line_error(p, R, J, p_BC, d_B)
            residual = np.linalg.norm(error, axis=1)
            better = residual < smallest
            best = np.where(better[:, None], q, best)
            smallest = np.minimum(smallest, residual)
            if step == iterations or smallest.max() < tolerance:
                break
            q = np.clip(q + _damped_step(E, error), self.lower, self.upper)
        return best, smallest

    def rates(self, q: Array, v_BC: Array, w_BF: Array) -> Array:
        """Return joint rates that move the contact line.

        Args:
            q: joint angles [rad], shape (K, 5).
            v_BC: velocity of C relative to and expressed in the torso [m/s], shape (K, 3).
            w_BF: angular velocity of the line, likewise [rad/s], shape (K, 3); its part
                along the line does not count.

        Returns:
            Joint rates [rad/s], shape (K, 5).
        """
        _, R, J = self.forward(q)
        E = _line_jacobian(R, J)
        target = np.concatenate([v_BC, np.einsum("kji,kj->ki", R[..., 1:], w_BF)], axis=1)
        return _damped_step(E, target)


def _line_jacobian(R: Array, J: Array) -> Array:
    """Return the rows of (51) in the torso frame, shape (K, 5, 5)."""
    return np.concatenate([J[:, :3], np.swapaxes(R[..., 1:], 1, 2) @ J[:, 3:]], axis=1)


def _line_error(p: Array, R: Array, J: Array, p_d: Array, d_d: Array) -> tuple[Array, Array]:
    """Return the five errors of a line and their Jacobian."""
    turn = _turn(R[..., 0], R[..., 2], d_d)
    error = np.concatenate([p_d - p, np.einsum("kji,kj->ki", R[..., 1:], turn)], axis=1)
    return error, _line_jacobian(R, J)


def _turn(x: Array, z: Array, d: Array) -> Array:
    """Return the rotation that takes the line x to d, of length sin below a right angle.

    Above, its length is the angle, since the sine would vanish again for a line that points
    backwards; one that points straight backwards turns about z.
    """
    turn = np.cross(x, d)
    cosine = np.einsum("ki,ki->k", x, d)
    behind = cosine < 0.0
    if np.any(behind):
        sine = np.linalg.norm(turn[behind], axis=1)
        axis = np.where((sine > 1e-9)[:, None], turn[behind], z[behind])
        angle = np.arctan2(sine, cosine[behind])
        turn[behind] = axis * (angle / np.linalg.norm(axis, axis=1))[:, None]
    return turn


def _damped_step(E: Array, error: Array, damping: float = 1e-8) -> Array:
    """Solve ``E step = error``, damped so that a straight knee gives a finite step."""
    Et = np.swapaxes(E, 1, 2)
    normal = Et @ E + damping * np.eye(E.shape[-1])
    return solve(normal, Et @ error[..., None])[..., 0]
