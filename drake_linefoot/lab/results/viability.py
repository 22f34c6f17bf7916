"""Whether its legs could save the robot of a recorded run after a push, as a pendulum."""

import numpy as np

from drake_linefoot.gait.constants import constants_of
from drake_linefoot.gait.footsteps import SIDE_SIGN
from drake_linefoot.gait.pendulum import dcm
from drake_linefoot.gait.state import GaitConstants
from drake_linefoot.gait.viability import StepBounds, can_step_on, is_viable
from drake_linefoot.lab.simulation.recording import Run
from drake_linefoot.lab.simulation.run_view import robot_of
from drake_linefoot.types import Array

_SAMPLES = 5  # over which the CoM's velocity is taken


def step_bounds(c: GaitConstants) -> StepBounds:
    """Return what steps the pendulum of a gait may make: as the robot's description and legs allow.

    The quickest is a recovery step; those after it are as long and wide as legs make any in its
    time, or another. `c` are the gait's constants.
    """
    duration = float(c.swing_time_min + c.double_support_min)
    return StepBounds(float(c.omega), duration, c.step_limits, c.offset_limits)


def soonest_step(c: GaitConstants, elapsed: float) -> float:
    """Return how soon the weight can come onto a foot that was lifted `elapsed` [s] ago [s].

    After a swing that only lifts it, and a recovery step's switch. `c` are the gait's constants.
    """
    return float(max(c.swing_time_min - elapsed, 0.0) + c.switch_min)


def capture_offset(run: Run, i: int, stance: int, omega: float) -> Array:
    """Return where the capture point of sample `i` is from a foot [m], shape (2,).

    Forward and to the side of the other foot; `omega` [1/s] is that of the pendulum.
    """
    before, yaw = max(i - _SAMPLES, 0), run.rpy[i, 2]
    velocity = (run.com[i] - run.com[before]) / max(run.time[i] - run.time[before], 1e-9)
    away = dcm(run.com[i], velocity, omega) - run.contact_points[i, stance, :, :2].mean(axis=0)
    ahead, left = away @ [np.cos(yaw), np.sin(yaw)], away @ [-np.sin(yaw), np.cos(yaw)]
    return np.array([ahead, SIDE_SIGN[1 - stance] * left])


def push_is_viable(run: Run) -> bool | None:
    """Return whether steps save the pendulum in the state in which the last push leaves it.

    Where both feet stand, any of them may be the first to step. None without a push, when the run
    ended before the push did, or where no pendulum can walk in the bounds of the robot's steps.
    """
    humanoid, scenario = robot_of(run), run.scenario
    ends = [push.time + push.duration for push in scenario.pushes if push.impulse]
    if not ends or max(ends) > run.time[-1]:
        return None
    i = int(np.searchsorted(run.time, max(ends) - 1e-9))
    c, elapsed = constants_of(scenario.gait, humanoid)[0], 0.0
    air = run.planned_contact < 0.5
    if air[i].any():
        landed = np.flatnonzero(~air[: i + 1].any(axis=1))
        lifted = int(landed[-1]) + 1 if len(landed) else 0
        elapsed = float(run.time[i] - run.time[lifted])
    bounds, soonest = step_bounds(c), soonest_step(c, elapsed)
    if not can_step_on(bounds):
        return None
    return any(
        is_viable(capture_offset(run, i, stance, bounds.omega), soonest, bounds)
        for stance in (0, 1)
        if not air[i, stance]
    )
