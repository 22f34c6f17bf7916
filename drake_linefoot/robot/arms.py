"""Which joints swing the arms: shoulders that turn about y."""

import numpy as np

from drake_linefoot.robot.dynamics import robot_dynamics
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.mirror import ALONG, joint_lines
from drake_linefoot.types import Array

_PITCH = 1  # row of the momentum about y


def arm_turns(humanoid: Humanoid) -> Array:
    """Return which way each joint of the arms turns when the right foot goes ahead.

    On each side one does: of those that turn about y, with all joints at 0, that with the largest
    momentum. The left arm goes ahead with the right foot.

    Returns:
        1, -1 or 0 of each of `Humanoid.arm_joints`, shape (m,); all 0 where left and right do not
        both have one.
    """
    d, turns = humanoid.description, np.zeros(len(humanoid.arm_v))
    names = [d.actuated_joints[i] for i in humanoid.arm_joints]
    pairs = [(i, names.index(d.mirror[n][0])) for i, n in enumerate(names) if n in d.mirror]
    pairs = [(left, right) for left, right in pairs if left != right]
    if not pairs:
        return turns
    _, axes = joint_lines(humanoid.names, humanoid.base.body_frame(), names)
    A = robot_dynamics(humanoid, humanoid.scratch, humanoid.x_nominal).A
    weight = np.abs(A[_PITCH, humanoid.arm_v]) * (np.abs(axes[:, 1]) > ALONG)
    left, right = max(pairs, key=lambda pair: weight[pair[0]])
    if weight[left] > 0.0 and weight[right] > 0.0:  # about +y a hanging arm turns back
        turns[left], turns[right] = -np.sign(axes[left, 1]), np.sign(axes[right, 1])
    return turns
