"""One instant of a walk, as the overlays draw it: from a diagram's signals or from a log."""

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from pydrake.systems.framework import Context

from drake_linefoot.constants import GRAVITY
from drake_linefoot.contact.wrench_cone import points_from_wrench
from drake_linefoot.robot.dynamics import contact_frame
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.simulation.feet import contact_points
from drake_linefoot.simulation.recording import Run
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


def measured_instant(humanoid: Humanoid, scratch: Context, time: float, x: Array) -> Instant:
    """Return what a state alone says.

    Args:
        humanoid: the robot.
        scratch: a context of `humanoid.plant`, which is overwritten.
        time: of the state [s].
        x: [q, v], shape (nq + nv,).
    """
    plant = humanoid.plant
    plant.SetPositionsAndVelocities(scratch, x)
    com = plant.CalcCenterOfMassPositionInWorld(scratch)
    velocity = plant.CalcCenterOfMassTranslationalVelocityInWorld(scratch)
    points = contact_points(humanoid, scratch)
    X_WB = plant.EvalBodyPoseInWorld(scratch, humanoid.base)
    ground = points[..., 2].min()
    omega = np.sqrt(-GRAVITY[2] / max(com[2] - ground, 1e-2))
    return Instant(
        time=time,
        com=com,
        contact_points=points,
        standing=_unknown(2),
        capture_point=np.array([*(com + velocity / omega)[:2], ground]),
        pushed=X_WB @ humanoid.base.default_com(),
    )


def recorded_instant(humanoid: Humanoid, scratch: Context, run: Run, i: int) -> Instant:
    """Return what a log says of its sample `i`; for the other arguments see above."""
    x = np.concatenate([run.q[i], run.v[i]])
    instant = measured_instant(humanoid, scratch, float(run.time[i]), x)
    instant.standing = run.planned_contact[i]
    instant.planned = run.mpc_footholds[i]
    instant.predicted = run.mpc_horizon[i]
    instant.swing = run.swing_position[i]
    instant.push = run.push[i]
    normal = run.true_normal[i]
    share = normal / np.maximum(normal.sum(axis=1, keepdims=True), 1e-9)  # of heel and toe
    instant.true_force = share[:, :, None] * run.true_force[i][:, None, :]
    instant.estimated_force = end_forces(run.contact_wrench[i], instant.contact_points)
    return instant


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


def sum_at_ends(forces: Iterable[tuple[Array, Array]], points: Array) -> Array:
    """Add up forces at the heel or toe that each is nearest to.

    Args:
        forces: pairs of a point [m] and a force on the robot [N] in W, shape (3,) each.
        points: heel and toe of each foot [m], shape (2, 2, 3).

    Returns:
        Forces in W [N], shape (2, 2, 3).
    """
    out = np.zeros((2, 2, 3))
    for point, force in forces:
        nearest = int(np.argmin(np.linalg.norm(points - point, axis=2)))
        out[nearest // 2, nearest % 2] += force
    return out
