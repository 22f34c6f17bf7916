"""One instant of a walk, as the overlays draw it: from a diagram's signals or from a log."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from pydrake.systems.framework import Context

from drake_linefoot.constants import GRAVITY
from drake_linefoot.contact.wrench_cone import points_from_wrench
from drake_linefoot.robot.dynamics import contact_frame
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.types import Array


def _unknown(*shape: int) -> Array:
    return np.full(shape, np.nan)


@dataclass
class Instant:
    """What is drawn of one instant. What is not known is NaN, and is not drawn.

    Attributes:
        time: of the simulation [s].
        com: centre of mass [m], shape (3,).
        contact_points: heel and toe of each foot [m], shape (2, 2, 3).
        standing: flags of the feet, shape (2,).
        planned: coming footholds [x, y, z, yaw], shape (n, 4).
        predicted: centre of mass over the MPC's horizon [m], shape (m, 3).
        capture_point: on the ground [m], shape (3,).
        swing: where the swing foot should be [m], shape (3,).
        true_force: on heel and toe of each foot, in W [N], shape (2, 2, 3).
        estimated_force: the same as the contact estimator has it.
        push: force on the torso in W [N], shape (3,).
        pushed: where it acts, the centre of mass of the torso [m], shape (3,).
    """

    time: float
    com: Array
    contact_points: Array
    standing: Array
    planned: Array = field(default_factory=lambda: np.empty((0, 4)))
    predicted: Array = field(default_factory=lambda: np.empty((0, 3)))
    capture_point: Array = field(default_factory=lambda: _unknown(3))
    swing: Array = field(default_factory=lambda: _unknown(3))
    true_force: Array = field(default_factory=lambda: _unknown(2, 2, 3))
    estimated_force: Array = field(default_factory=lambda: _unknown(2, 2, 3))
    push: Array = field(default_factory=lambda: _unknown(3))
    pushed: Array = field(default_factory=lambda: _unknown(3))


def instant_of(humanoid: Humanoid, scratch: Context, sample: Any) -> Instant:
    """Return what a sample says.

    Args:
        humanoid: the robot.
        scratch: a context of `humanoid.plant`, which is overwritten.
        sample: of the channels of a `Run`, by name: a row of a recorder, or `Run.sample`.
    """
    plant, com, points = humanoid.plant, sample["com"], sample["contact_points"]
    plant.SetPositionsAndVelocities(scratch, np.concatenate([sample["q"], sample["v"]]))
    velocity = plant.CalcCenterOfMassTranslationalVelocityInWorld(scratch)
    X_WB = plant.EvalBodyPoseInWorld(scratch, humanoid.base)
    ground = points[..., 2].min()
    omega = np.sqrt(-GRAVITY[2] / max(com[2] - ground, 1e-2))
    normal = sample["true_normal"]
    share = normal / np.maximum(normal.sum(axis=1, keepdims=True), 1e-9)  # of heel and toe
    return Instant(
        time=float(sample["time"]),
        com=com,
        contact_points=points,
        standing=sample["planned_contact"],
        planned=sample["mpc_footholds"],
        predicted=sample["mpc_horizon"],
        capture_point=np.array([*(com + velocity / omega)[:2], ground]),
        swing=sample["swing_position"],
        true_force=share[:, :, None] * sample["true_force"][:, None, :],
        estimated_force=end_forces(sample["contact_wrench"], points),
        push=sample["push"],
        pushed=X_WB @ humanoid.base.default_com(),
    )


def end_forces(wrench: Array, points: Array) -> Array:
    """Split the wrench of each foot into forces at heel and toe.

    Args:
        wrench: [f in W, tau_y and tau_z in C] [N, N m], shape (2, 5).
        points: heel and toe of each foot [m], shape (2, 2, 3).

    Returns:
        Forces in W [N], shape (2, 2, 3).
    """
    out = np.empty((2, 2, 3))
    for side in range(2):
        line = points[side, 1] - points[side, 0]
        length = float(np.linalg.norm(line))
        R = contact_frame(np.outer(line / length, [1.0, 0.0, 0.0]))
        in_foot = np.concatenate([R.T @ wrench[side, :3], wrench[side, 3:]])
        for end, force in enumerate(points_from_wrench(in_foot, 0.5 * length, 1.0)):
            out[side, end] = R @ force
    return out
