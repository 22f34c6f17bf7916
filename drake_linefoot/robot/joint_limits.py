"""Limits of a robot's joints, as its model has them, and whether they make sense."""

from typing import NamedTuple

import numpy as np
from pydrake.multibody.plant import MultibodyPlant

from drake_linefoot.robot.description import HumanoidDescription
from drake_linefoot.types import Array, Indices

WIDEST = 1e4  # [rad, m] of a position limit
SPEEDS, EFFORTS = (1e-3, 1e4), (1e-3, 1e6)  # [rad/s, m/s], [N m, N] of other limits


class JointLimits(NamedTuple):
    """Limits of the actuated joints, shape (na,) each.

    Attributes:
        lower, upper: least and greatest position [rad, m].
        velocity: symmetric [rad/s, m/s].
        effort: symmetric [N m, N].
    """

    lower: Array
    upper: Array
    velocity: Array
    effort: Array


def read_limits(
    plant: MultibodyPlant, description: HumanoidDescription, q: Indices, v: Indices
) -> JointLimits:
    """Return the limits of the actuated joints, at q and v of a finalized plant.

    Raises:
        ModelError: one is not finite, or beyond what joints have.
    """
    limits = JointLimits(
        plant.GetPositionLowerLimits()[q],
        plant.GetPositionUpperLimits()[q],
        plant.GetVelocityUpperLimits()[v],
        plant.GetEffortUpperLimits(),
    )
    for values, what, low, high in (
        (limits.lower, "lower position limit", -WIDEST, WIDEST),
        (limits.upper, "upper position limit", -WIDEST, WIDEST),
        (limits.velocity, "velocity limit", *SPEEDS),
        (limits.effort, "effort limit", *EFFORTS),
    ):
        for name, value in zip(description.actuated_joints, values, strict=True):
            if not np.isfinite(value):
                raise description.refuse("model", name, f"joint has no finite {what}")
            if not low <= value <= high:
                allowed = f"{what} must lie in [{low:g}, {high:g}]"
                raise description.refuse("model", name, allowed)
    return limits
