"""Where heels and toes are."""

import numpy as np
from pydrake.systems.framework import Context

from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.types import Array


def contact_points(humanoid: Humanoid, context: Context) -> Array:
    """Return heel and toe of each foot in W [m], shape (2, 2, 3).

    Args:
        humanoid: the robot.
        context: context of `humanoid.plant` that holds its positions.
    """
    return np.stack(
        [
            (frame.CalcPoseInWorld(context) @ foot.contact_points.T).T
            for frame, foot in zip(humanoid.foot_frames, humanoid.description.feet, strict=True)
        ]
    )
