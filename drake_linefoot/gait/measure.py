"""What the gait measures of the robot."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.gait.planner import GaitMeasurement
from drake_linefoot.robot.humanoid import Humanoid

if TYPE_CHECKING:
    from pydrake.systems.framework import Context

Array = NDArray[np.float64]


def measure_gait(
    humanoid: Humanoid, context: Context, x: Array, contact: tuple[bool, bool]
) -> GaitMeasurement:
    """Return CoM and contact lines of a state.

    Args:
        humanoid: the robot.
        context: scratch context of its plant; overwritten.
        x: state [q, v].
        contact: flags of the contact estimator.
    """
    plant = humanoid.plant
    plant.SetPositionsAndVelocities(context, x)
    feet = np.empty((2, 4))
    for side, frame in enumerate(humanoid.foot_frames):
        X_WF = frame.CalcPoseInWorld(context)
        x_F = X_WF.rotation().col(0)
        feet[side, :3] = X_WF @ humanoid.p_FC[side]
        feet[side, 3] = np.arctan2(x_F[1], x_F[0])
    return GaitMeasurement(
        com=plant.CalcCenterOfMassPositionInWorld(context),
        com_velocity=plant.CalcCenterOfMassTranslationalVelocityInWorld(context),
        feet=feet,
        contact=contact,
    )
