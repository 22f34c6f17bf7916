"""What a robot does now otherwise than it was told, as words for progress and pages."""

import numpy as np

from drake_linefoot.lab.simulation.channels import LIMITS
from drake_linefoot.lab.simulation.recorder import Recorder
from drake_linefoot.lab.simulation.velocity import ENOUGH, recent_samples, recent_velocity
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.types import Array, Flags

STOP = 0.01  # [rad] from a joint's stop
_LEAST = 0.05  # [m/s] of a speed that has a direction
_OFTEN = 0.5  # [-] of the window


def warnings_of(recorder: Recorder, humanoid: Humanoid) -> list[str]:
    """Return what a robot does otherwise than it was told, over the last half second.

    Why the gait follows another command; which joints of the legs are at their stops for half of
    it or longer (see `joints_at_stops`); that it walks against its command, given long before.
    """
    limited = LIMITS[int(np.nan_to_num(recorder.samples("reference_limited", 1)).sum())]
    said = [f"command limited: {limited}"] if limited else []
    recent = recent_samples(recorder)
    angles = recorder.samples("q", ENOUGH)[recent][:, humanoid.actuated_q]
    stands = recorder.samples("planned_contact", ENOUGH)[recent] > _OFTEN
    names = humanoid.description.actuated_joints
    there = joints_at_stops(humanoid, angles, stands)
    often = there.sum(axis=0) > _OFTEN * max(len(there), 1)
    said += [f"{names[k]} at its stop" for k in humanoid.leg_joints[often]]
    told = recorder.samples("command", 2 * ENOUGH)[:, :2]
    long = len(told) == 2 * ENOUGH and bool(np.ptp(told, axis=0).max() == 0.0)
    if long and np.hypot(*told[-1]) > _LEAST:
        along = recent_velocity(recorder)[:2] @ told[-1] / np.hypot(*told[-1])
        if along < -_LEAST:
            said.append("walks against its command")
    return said


def joints_at_stops(humanoid: Humanoid, angles: Array, stands: Flags) -> Flags:
    """Return when the joints of the legs are at their stops.

    The ankle of a foot in the air does not count: every long step takes it there.

    Args:
        humanoid: whose joints they are.
        angles: of the actuated joints [rad], shape (n, na).
        stands: whether each foot bears load, shape (n, 2).

    Returns:
        Shape (n, 2, n_leg).
    """
    margin = np.minimum(angles - humanoid.position_lower, humanoid.position_upper - angles)
    there = margin[:, humanoid.leg_joints] < STOP  # n, 2, n_leg
    there[:, :, -1] &= stands
    return there
