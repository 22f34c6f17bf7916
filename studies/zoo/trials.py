"""A robot of the zoo, its feet lines or surfaces: described from its model alone, and walked.

Its fastest walk is found.
"""

import math
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from drake_linefoot.constants import STANDARD_GRAVITY
from drake_linefoot.errors import ModelError
from drake_linefoot.lab.new_robot.analysis import analyse
from drake_linefoot.lab.new_robot.folder import first_speed, write_folder
from drake_linefoot.lab.results.fall_indicators import SLIP, fall_indicators
from drake_linefoot.lab.results.gait_figures import at_limit
from drake_linefoot.lab.results.judge import judge, upright
from drake_linefoot.lab.results.metrics import compute_metrics, segment_velocity
from drake_linefoot.lab.results.poses import draw_walk
from drake_linefoot.lab.scenario import Perturbation, Scenario, Segment
from drake_linefoot.lab.scenario.load import load_scenario
from drake_linefoot.lab.simulation.recording import Run
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.robot.description import LINE, SCENARIO, SURFACE
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.scaling import units_of
from studies.common.files import write_picture
from studies.common.stamp import Probed
from studies.common.trial import STAND, often_at_limit, walk
from studies.common.types import Data
from studies.envelope.walks import reason
from studies.zoo.disturbed import pushed, side_drift
from studies.zoo.robots import make

CONTACTS = (LINE, SURFACE)
TURN, ASIDE = 0.5, 0.2  # [rad/s], [m/s] of a robot of the MIT Humanoid's size
MISS, TURN_MISS = 0.1, 0.15  # [m/s], [rad/s] by which one may miss its command
ANGLE, RATE, PUSH = 0.01, 0.1, 0.05  # [rad], [rad/s], [m/s] of the initial perturbation, likewise
FORWARD = "forward"
SKILLS = ("stand", "step in place", FORWARD, "turn", "sidestep", "stop")
DURATIONS = (1.0, 3.0, 4.0, 4.0, 4.0, 2.0)  # [s] of each skill
RUNG, FIRST, LAST = 0.05, 2, 20  # [-] of sqrt(g h) between two speeds that are tried; of these
RUNG_TIME = 6.0  # [s]
FOLLOWS = 0.5  # [-] of its command: what walks slower does not follow it


@dataclass(frozen=True)
class Job:
    """What is tried of a robot."""

    name: str  # of the robot
    model: Path | None  # its file; None for a made-up one
    contact: str  # how its feet are to touch, `LINE` or `SURFACE`
    pictures: Path  # folder
    seeds: Sequence[int]  # of the initial perturbations
    last: int  # rung of the ladder of speeds
    pace: float  # of the durations [-]
    directions: tuple[int, ...]  # of the pushes [deg]


def met(job: Job) -> Data:
    """Describe a robot and walk it.

    Returns:
        `refused`: why it is, with nothing else; or None, with `mass` [kg], `com_height` [m],
        `locked` joints, `skills`: seeds that showed each, `falls`: what ended or spoilt a run;
        `fastest` (see `fastest`); `slip` [m], the largest; `pushed`, upright by direction [deg];
        `side_drift` [m/s] on a slope; `picture`: its file.
    """
    with tempfile.TemporaryDirectory() as scratch:
        model = make(job.name, Path(scratch)) if job.model is None else job.model
        try:
            found = analyse(model, contact=job.contact)
        except ModelError as error:
            return {"refused": f"{error.entry} = {error.value!r}: {error.allowed}"}
        write_folder(folder := Path(scratch) / "robot", found)
        scenario = load_scenario(str(folder / SCENARIO))
        humanoid = found.humanoid
        row: Data = {
            "refused": None,
            "mass": humanoid.mass,
            "com_height": humanoid.com_height,
            "locked": list(humanoid.description.lock),
        }
        skills, runs = shown(humanoid, scenario, job)
        picture = f"{job.name}.png" if job.contact == LINE else f"{job.name}_{job.contact}.png"
        write_picture(job.pictures / picture, draw_walk(runs[0], FORWARD))
        return {
            **row,
            **skills,
            "fastest": fastest(humanoid, scenario, job),
            "pushed": pushed(humanoid, scenario, job.directions),
            "side_drift": side_drift(humanoid, scenario, job.pace),
            "picture": picture,
        }


def probe() -> dict[str, Probed]:
    """Return a quick form of the study: a made-up robot on lines, each skill for a while."""
    name = "no_arms"
    with tempfile.TemporaryDirectory() as scratch:
        found = analyse(make(name, Path(scratch)), contact=LINE)
        write_folder(folder := Path(scratch) / "robot", found)
        scenario = load_scenario(str(folder / SCENARIO))
        job = Job(name, None, LINE, Path(scratch), (0,), FIRST, 0.5, ())
        skills, _ = shown(found.humanoid, scenario, job)
    seeds = {skill: Probed(float(skills["skills"][skill]), 0.0) for skill in SKILLS}
    return {**seeds, "mass_kg": Probed(found.humanoid.mass, 1e-6)}


def commanded(humanoid: Humanoid, pace: float) -> list[Segment]:
    """Return the segments that show each of `SKILLS`, in the size of a robot."""
    size = units_of(humanoid)
    ahead = first_speed(humanoid.com_height)
    moves: dict[str, Any] = {
        "step in place": {},
        FORWARD: {"velocity": [ahead, 0.0]},
        "turn": {"turn_rate": TURN / size["s"]},
        "sidestep": {"velocity": [0.0, ASIDE * size["m"] / size["s"]]},
    }
    return [
        Segment(name, pace * time, walk=name in moves, **moves.get(name, {}))
        for name, time in zip(SKILLS, DURATIONS, strict=True)
    ]


def shown(humanoid: Humanoid, scenario: Scenario, job: Job) -> tuple[Data, list[Run]]:
    """Return which skills were shown under each seed, and the runs."""
    size = units_of(humanoid)
    speed = size["m"] / size["s"]
    start = Perturbation(ANGLE, RATE / size["s"], PUSH * speed)
    runs, falls, slips, skills = [], [], [], dict.fromkeys(SKILLS, 0)
    for seed in job.seeds:
        segments = commanded(humanoid, job.pace)
        run = simulate(
            build_closed_loop(replace(scenario, segments=segments, perturbation=start, seed=seed))
        )
        missed = []
        for found in compute_metrics(run)["segments"]:
            error = found["error"]
            if error is None:
                continue
            held = np.hypot(*error[:2]) <= MISS * speed and abs(error[2]) <= TURN_MISS / size["s"]
            skills[found["name"]] += int(held)
            if not held:
                measured = ", ".join(f"{v:.2f}" for v in found["measured"])
                wanted = ", ".join(f"{v:.2f}" for v in found["commanded"])
                missed.append(f"{found['name']}: {measured} instead of {wanted}")
        outcome = judge(run)
        if not upright(outcome):
            missed.append(f"{segment_at(run)}: {reason(run, None)}{at_limits(run)}")
        falls += [{"seed": seed, "time": run.fall_time, "what": text} for text in missed]
        runs.append(run)
        slips.append(outcome["slip"])
    return {"skills": skills, "falls": falls, "slip": max(slips)}, runs


def fastest(humanoid: Humanoid, scenario: Scenario, job: Job) -> Data:
    """Walk faster and faster, until the robot falls, slips or does not follow.

    Returns:
        `speed`: the largest that was measured before that [m/s], and `share`: by sqrt(g h) [-];
        `stopped_at`: speed that was commanded then [m/s], and `stopped_by`: why; None, if
        nothing did.
    """
    unit = math.sqrt(STANDARD_GRAVITY * humanoid.com_height)
    scenario = replace(
        scenario, seed=0, gait=replace(scenario.gait, forward_max=LAST * RUNG * unit)
    )
    best: Data = {"speed": 0.0, "share": 0.0, "stopped_at": None, "stopped_by": None}
    for rung in range(FIRST, job.last + 1):
        command = rung * RUNG * unit
        run = simulate(build_closed_loop(walk(scenario, (command, 0.0, 0.0), RUNG_TIME)))
        measured = segment_velocity(run, STAND, RUNG_TIME)
        why = stopped_by(run, command, None if measured is None else float(measured[0]))
        if measured is None or why:
            return {**best, "stopped_at": command, "stopped_by": why + at_limits(run)}
        best["speed"] = max(best["speed"], float(measured[0]))
        best["share"] = best["speed"] / unit
    return best


def stopped_by(run: Run, command: float, measured: float | None) -> str:
    """Return what was wrong with a walk forward; nothing when it went well."""
    if measured is None or not upright(judge(run)):
        return reason(run, None)
    slips = [s for s in fall_indicators(run, 0, len(run.time)) if s.name == SLIP]
    if slips:
        return f"slips at {slips[0].begin:.2f} s: {slips[0].what}"
    return f"walks {measured:.2f} m/s only" if measured < FOLLOWS * command else ""


def at_limits(run: Run) -> str:
    """Return which joint is at its torque limit most, and in what share of the ticks."""
    often = often_at_limit(run.joint_names, at_limit(run))
    worst = [f"; {joint} at its torque limit in {n:.0%} of the ticks" for joint, n in often.items()]
    return worst[0] if worst else ""


def segment_at(run: Run) -> str:
    """Return the name of the segment in which a run ended."""
    ends = np.cumsum([segment.duration for segment in run.scenario.segments])
    segments = run.scenario.segments
    return segments[min(int(np.searchsorted(ends, run.time[-1])), len(segments) - 1)].name
