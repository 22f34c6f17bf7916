"""One trial: simulated until the course is done, and what came of it as plain data."""

import numpy as np
from pydrake.systems.framework import Context

from drake_linefoot.lab.plants.ground import Ground
from drake_linefoot.lab.results.clearance import STRIDE, shank_clearance
from drake_linefoot.lab.scenario.courses import SpiralParameters
from drake_linefoot.lab.simulation.recording import Run
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.simulation.run_view import robot_of
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from studies.common import paired
from studies.common.stamp import Probed
from studies.common.types import Data
from studies.ground.cases import Trial, course_of, goal_of, length_of, progress, scenario

Job = Trial | paired.Draw
LIMIT = 1800.0  # [s] of wall time of a trial
SETTLED = 0.02  # [s] after which a foot that has landed stands where it stands
SHANK_MET = "a shank met the ground"
OVER = 0.02  # [m] of a heel or a toe above what is below it, from where it is over an edge


def tried(trial: Trial) -> Data:
    """Simulate a trial.

    Returns:
        `key`, `case`, `index`; `done`: whether the torso came to the end of the course upright, and
        no shank met the ground, through which it passes in a simulator; `reason` why not; `speed`
        on the course [m/s], None where it was not done; `cut`: torques that had to be limited, by
        joint and tick; `over_edge`: landings with heel or toe over an edge; `landings`;
        `distance` along the course [m].
    """
    course, made = course_of(trial), scenario(trial)
    loop = build_closed_loop(made)
    place = np.zeros((1, 2))

    def look(root: Context) -> None:
        place[0] = loop.plant.state(root)[4:6]

    def stop() -> bool:  # what comes behind the goal does not count
        return bool(progress(course, place)[0] >= goal_of(course))

    run = simulate(loop, look=look, stop=stop)
    along = progress(course, run.q[:, 4:6])
    arrived = np.flatnonzero(along >= goal_of(course))
    last = int(arrived[0]) + 1 if len(arrived) else len(along)
    entered = np.flatnonzero(along >= 0.0)
    speed, aslant = None, 1.0 if isinstance(course, SpiralParameters) else np.cos(course.heading)
    if len(arrived):
        left = int(np.flatnonzero(along >= length_of(course))[0])
        way, time = along[left] - along[entered[0]], run.time[left] - run.time[entered[0]]
        speed = float(way / (aslant * time)) if time > 0.0 else None
    over, landings = landings_over_edges(run, loop.ground, last)
    reason = "" if len(arrived) else run.fall_reason or "too slow"
    if not reason and shank_clearance(robot_of(run), loop.ground, run.q[:last:STRIDE]).min() < 0.0:
        reason = SHANK_MET
    row = {"key": trial.key, "case": trial.case, "index": trial.index, "done": not reason}
    row |= {"reason": reason}
    row |= {"speed": speed, "cut": int(run["report.clipped"][:last].sum())}
    row |= {"over_edge": over, "landings": landings, "distance": float(along[:last].max())}
    loop.recorder.keep_last(0)
    return row


def tried_or_drawn(job: Job) -> Data:
    """Simulate a trial, or a draw of the sweep."""
    return tried(job) if isinstance(job, Trial) else paired.drawn(job)


def probe() -> dict[str, Probed]:
    """Return a quick form of the study: what came of the first walk up stairs."""
    row = tried(Trial("stairs_up_12", 0))
    found = {"done": Probed(float(row["done"]), 0.0), "cut": Probed(float(row["cut"]), 50.0)}
    if row["speed"] is not None:
        found["speed_m_s"] = Probed(row["speed"], 0.03)
    return found


def limit(job: Job) -> float:
    """Return how long a job may take [s]."""
    return LIMIT if isinstance(job, Trial) else paired.LIMIT


def lost(job: Job, error: str) -> Data:
    """Return what stands for `tried_or_drawn` of a job whose process crashed or took too long."""
    if not isinstance(job, Trial):
        return paired.lost(job, error)
    row = {"key": job.key, "case": job.case, "index": job.index, "done": False}
    nothing = {"speed": None, "cut": 0, "over_edge": 0, "landings": 0, "distance": 0.0}
    return {**row, "reason": error, **nothing}


def landings_over_edges(run: Run, ground: Ground, last: int) -> tuple[int, int]:
    """Return how many landings had a heel or a toe over an edge, and how many there were."""
    over = landings = 0
    stands = run["targets.contact"][:last] > 0.5
    for foot in range(2):
        begins = np.flatnonzero(stands[1:, foot] & ~stands[:-1, foot]) + 1
        for begin in begins:
            at = begin + round(SETTLED / float(run.time[1] - run.time[0]))
            if at < last and stands[at, foot]:
                points = run.contact_points[at, foot]
                gap = points[:, 2] - ground.height(points[:, 0], points[:, 1])
                over, landings = over + bool(gap.max() > OVER), landings + 1
    return over, landings
