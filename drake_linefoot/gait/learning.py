"""What the gait learns of its own speed at every touchdown."""

from drake_linefoot.gait.footsteps import heading_vector
from drake_linefoot.gait.state import GaitConstants, GaitState
from drake_linefoot.math.compiled import compiled


@compiled
def clear_touchdown_history(s: GaitState) -> None:
    """Forget earlier touchdowns."""
    s.speed.history[:] = 0.0
    s.speed.history[:, 0] = -1.0


@compiled
def forget_speed(s: GaitState, c: GaitConstants) -> None:
    """Begin to learn the speed anew; a run goes as commanded but for little."""
    s.speed.scale[:], s.speed.offset[:] = c.speed_scale, 0.0
    if s.command.flight > 0.0:
        s.speed.scale[:] = 1.0
    clear_touchdown_history(s)


@compiled
def update_speed_estimate(s: GaitState, steady: bool, c: GaitConstants) -> None:
    """Compare the speed over the last two steps with the command, once a step.

    The pendulum leaves out the legs, so a walk that follows it is a little slower
    than commanded, in proportion; a turn in place goes round a little beside the feet.
    So an error goes to a scale at speed, and to an offset at rest, more slowly: there it is
    mostly of the ground. While the command changes nothing is learned.

    Args:
        s: state of the gait at touchdown; its `speed` changes.
        steady: whether the velocity has reached the command.
        c: constants.
    """
    if not steady:
        clear_touchdown_history(s)
        return
    since = s.clock.time - s.speed.history[1, 0]
    if s.speed.history[1, 0] >= 0.0:
        vx, vy = (
            (s.robot.com[0] - s.speed.history[1, 1]) / since,
            (s.robot.com[1] - s.speed.history[1, 2]) / since,
        )
        travelled = heading_vector(0.5 * s.command.turn_rate * since - s.command.yaw, vx, vy)
        slow = c.speed_learning_slow
        for i in range(2):
            v = s.command.velocity[i]
            error = (v - travelled[i]) / (v * v + slow * slow)
            scale = s.speed.scale[i] + c.speed_learning * error * v
            offset = s.speed.offset[i] + c.speed_offset_learning * error * slow**2
            s.speed.scale[i] = min(max(scale, 1.0 / c.speed_scale_max), c.speed_scale_max)
            s.speed.offset[i] = min(max(offset, -c.speed_offset_max), c.speed_offset_max)
    s.speed.history[1] = s.speed.history[0]
    s.speed.history[0, 0], s.speed.history[0, 1], s.speed.history[0, 2] = (
        s.clock.time,
        s.robot.com[0],
        s.robot.com[1],
    )
