"""A robot of the zoo disturbed: pushed while it stands, and on a slope that rises to its left."""

import math
from dataclasses import replace

from drake_linefoot.constants import STANDARD_GRAVITY
from drake_linefoot.lab.new_robot.folder import first_speed
from drake_linefoot.lab.results.judge import judge, upright
from drake_linefoot.lab.results.metrics import segment_velocity
from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.scenario.disturbances import PushParameters
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.robot.humanoid import Humanoid

AHEAD, BESIDE = 0.24, 0.14  # [-] of m sqrt(g h): axes of the ellipse of pushes
DIRECTIONS = tuple(range(0, 360, 45))  # [deg]
STAND, AFTER = 1.0, 3.0  # [s] before a push, and from its beginning on
SCENE = "slope_10"
UP, TURNED, IN_PLACE = 4.0, 4.0, 10.0  # [s] of the walk up the slope, of a turn, and after it


def impulse(humanoid: Humanoid, direction: float) -> float:
    """Return a push [N s] in a direction [rad] from ahead: a point of the ellipse."""
    unit = humanoid.mass * math.sqrt(STANDARD_GRAVITY * humanoid.com_height)
    return unit / math.hypot(math.cos(direction) / AHEAD, math.sin(direction) / BESIDE)


def pushed(humanoid: Humanoid, scenario: Scenario, directions: tuple[int, ...]) -> dict[str, bool]:
    """Return whether a robot that stands stays upright, by the direction of the push [deg]."""
    stand = [Segment("stand", STAND + AFTER)]
    found = {}
    for degrees in directions:
        direction = math.remainder(math.radians(degrees), math.tau)
        push = PushParameters(STAND, impulse=impulse(humanoid, direction), direction=direction)
        run = simulate(build_closed_loop(replace(scenario, segments=stand, pushes=[push])))
        found[str(degrees)] = upright(judge(run))
    return found


def side_drift(humanoid: Humanoid, scenario: Scenario, pace: float) -> float | None:
    """Return how fast a walk in place goes to the left, up a slope of 10 degrees [m/s].

    The robot walks up the slope and turns to the right on it. Over the second half of what
    follows, when the slope was learned; None for a robot that falls.
    """
    ahead = first_speed(humanoid.com_height)
    up, turned, in_place = pace * UP, pace * TURNED, pace * IN_PLACE
    segments = [
        Segment("stand", 0.5 * STAND),
        Segment("up", up, walk=True, velocity=[ahead, 0.0]),
        Segment("turn", turned, walk=True, turn_rate=-0.5 * math.pi / turned),
        Segment("in place", in_place, walk=True),
    ]
    run = simulate(build_closed_loop(replace(scenario, scene=SCENE, segments=segments)))
    end = run.scenario.duration
    measured = segment_velocity(run, end - in_place, end)
    return float(measured[1]) if measured is not None and upright(judge(run)) else None
