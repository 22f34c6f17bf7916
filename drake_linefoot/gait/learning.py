"""What the gait learns of its own speed at every touchdown."""

import numpy as np

from drake_linefoot.gait.footsteps import heading_vector
from drake_linefoot.math.compiled import compiled


@compiled
def forget_marks(s: np.record) -> None:
    """Drop the marks of earlier touchdowns from the gait's state, see `state.GAIT`."""
    s.marks[:] = 0.0
    s.marks[:, 0] = -1.0


@compiled
def forget_speed(s: np.record, c: np.record) -> None:
    """Begin to learn the speed anew."""
    s.speed_scale[:], s.speed_offset[:] = c.speed_scale, 0.0
    forget_marks(s)


@compiled
def learn_speed(s: np.record, steady: bool, c: np.record) -> None:
    """Compare the speed over the last two steps with the command, once a step.

    The pendulum leaves out the legs, so a walk that follows it is a little slower
    than commanded, in proportion; a turn in place goes round a little beside the feet.
    So an error goes to a scale at speed, and to an offset at rest, more slowly: there it is
    mostly of the ground. While the command changes nothing is learned.

    Args:
        s: state of the gait at touchdown: `speed_scale`, `speed_offset` and `marks` change.
        steady: whether the velocity has reached the command.
        c: constants.
    """
    if not steady:
        forget_marks(s)
        return
    since = s.time - s.marks[1, 0]
    if s.marks[1, 0] >= 0.0:
        vx, vy = (s.com[0] - s.marks[1, 1]) / since, (s.com[1] - s.marks[1, 2]) / since
        travelled = heading_vector(0.5 * s.turn_rate * since - s.yaw, vx, vy)
        slow = c.speed_learning_slow
        for i in range(2):
            v = s.velocity[i]
            error = (v - travelled[i]) / (v * v + slow * slow)
            scale = s.speed_scale[i] + c.speed_learning * error * v
            offset = s.speed_offset[i] + c.speed_offset_learning * error * slow**2
            s.speed_scale[i] = min(max(scale, 1.0 / c.speed_scale_max), c.speed_scale_max)
            s.speed_offset[i] = min(max(offset, -c.speed_offset_max), c.speed_offset_max)
    s.marks[1] = s.marks[0]
    s.marks[0, 0], s.marks[0, 1], s.marks[0, 2] = s.time, s.com[0], s.com[1]
