"""A walk in one call."""

from pathlib import Path
from typing import Any

from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.simulation.recording import Run
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop

STAND, STOP = 0.5, 2.0  # [s] before and after the walk


def walk(
    vx: float = 0.5,
    vy: float = 0.0,
    turn_rate: float = 0.0,
    duration: float = 5.0,
    robot: str | Path = "mit_humanoid",
    **fields: Any,
) -> Run:
    """Stand for half a second, walk with one command, stop within two seconds; return the run.

        run = walk(vx=0.6, turn_rate=0.3, seed=2)
        print(run.fell, run.com[-1])

    Args:
        vx: forward velocity [m/s].
        vy: velocity to the left [m/s].
        turn_rate: counter-clockwise positive [rad/s].
        duration: of the walk between standing and stopping [s].
        robot: a shipped one, the folder that `linefoot new-robot` wrote, or a description's path.
        fields: any other field of a `Scenario`, such as `seed`, `scene`, `pushes`, `estimation`.

    Returns:
        The recorded run, which ends early when the robot falls.

    Raises:
        InputError: a field, or the robot, cannot be used.
        TypeError: a scenario has no such field.
    """
    segments = [
        Segment("stand", STAND),
        Segment("walk", duration, walk=True, velocity=[vx, vy], turn_rate=turn_rate),
        Segment("stop", STOP),
    ]
    return simulate(build_closed_loop(Scenario(robot=str(robot), segments=segments, **fields)))
