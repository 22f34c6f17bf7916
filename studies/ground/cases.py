"""What is tried on known ground: cases, their bars, and the scenario of each trial."""

import atexit
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from shutil import rmtree
from tempfile import mkdtemp
from typing import Any

import numpy as np

from drake_linefoot.lab.new_robot.analysis import analyse
from drake_linefoot.lab.new_robot.folder import scenario_beside, write_folder
from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.scenario.courses import (
    BlocksParameters,
    CourseParameters,
    GapsParameters,
    SpiralParameters,
    StairsParameters,
    StonesParameters,
    TerrainParameters,
)
from drake_linefoot.lab.scenario.disturbances import PushParameters
from drake_linefoot.lab.scenario.load import load_scenario
from drake_linefoot.robot.description import robot_file
from drake_linefoot.types import Array
from studies.common.trials import FRESH
from studies.zoo.soled import BIPED, write_soled

STAND = 0.5  # [s] before anything
RUNS, WALKS_RUNS, QUICK_RUNS = 200, 50, 2  # of a case; of one that asks if it walks; of any
SPEED, SLOW = 0.4, 0.3  # [m/s] of the command
STEPS, TREAD, HEADING = 6, (0.25, 0.30), 0.3  # [-], [m], [rad] in which stairs lie
AT = (0.5, 0.8)  # [m] where a course begins
BEYOND = 0.4  # [m] behind the course: there it is done
SLOWNESS = 1.6  # [-] of the time that the command takes, that a run lasts
PUSH, PUSH_TIME = 10.0, (1.5, 4.5)  # [N s], [s] between which it comes
NAMES = {
    StairsParameters: "stairs",
    GapsParameters: "gaps",
    StonesParameters: "stones",
    BlocksParameters: "blocks",
    SpiralParameters: "spiral",
}
SOLE = (0.17, 0.06)  # [m] length and width of the biped's
WALKS = 0.5  # [-] share of the runs from where it counts as walking
BLIND = 0.04  # [m] of the highest stairs that are climbed without a map
OFF = 0.02  # [m] of a map that errs, in place and in height


@dataclass(frozen=True)
class Case:
    """Trials of a kind."""

    what: str
    bar: float  # [-] share of the runs that are to be done
    kind: type[CourseParameters]
    numbers: dict[str, Any] = field(default_factory=dict)
    speed: float = SPEED
    estimation: bool = False
    terrain: TerrainParameters = field(default_factory=lambda: TerrainParameters("scene"))
    push: float = 0.0
    simulator: str = "drake"
    on_soles: bool = False  # the biped of the zoo in place of the MIT Humanoid

    @property
    def runs(self) -> int:
        """How many there are: fewer where the question is whether it walks at all."""
        return WALKS_RUNS if self.bar == WALKS else RUNS


def _stairs(what: str, bar: float, rise: float, **changes: Any) -> Case:
    speed = SLOW if rise < -0.13 else SPEED
    return Case(what, bar, StairsParameters, {"rise": rise}, **{"speed": speed, **changes})


LOST = TerrainParameters("scene", known=[[2.0, 4.5]])
OFF_MAP = TerrainParameters("scene", noise=OFF, error=OFF)
CASES = {
    "stairs_up_12": _stairs("up stairs of 12 cm", 0.95, 0.12),
    "stairs_down_12": _stairs("down stairs of 12 cm", 0.95, -0.12),
    "stairs_up_15": _stairs("up stairs of 15 cm", 0.85, 0.15),
    "stairs_down_15": _stairs("down stairs of 15 cm", 0.75, -0.15),
    "up_12_map_off": _stairs("up with a map off by up to 2 cm", 0.9, 0.12, terrain=OFF_MAP),
    "down_12_map_off": _stairs("down with a map off by up to 2 cm", 0.9, -0.12, terrain=OFF_MAP),
    "up_12_estimate": _stairs("up on the estimate", 0.9, 0.12, estimation=True),
    "down_12_estimate": _stairs("down on the estimate", 0.9, -0.12, estimation=True),
    "up_12_push": _stairs("up with a push of 10 N s", 0.85, 0.12, push=PUSH),
    "down_12_push": _stairs("down with a push of 10 N s", 0.85, -0.12, push=PUSH),
    "gaps_20": Case("over gaps of 20 cm", 0.95, GapsParameters),
    "stones": Case("on stones of 25 x 25 cm, 10 cm apart", 0.9, StonesParameters),
    "blocks": Case("on blocks of +-5 cm and 10 degrees", 0.95, BlocksParameters),
    "spiral_12": Case("up a spiral stair of 12 cm", WALKS, SpiralParameters, speed=SLOW),
    "map_for_a_while": _stairs(
        "up stairs of 4 cm, known from 2 to 4.5 s alone", WALKS, BLIND, terrain=LOST, speed=SLOW
    ),
    "soles_up_12": _stairs("on soles up stairs of 12 cm", WALKS, 0.12, on_soles=True, speed=SLOW),
    "up_12_mujoco": _stairs("up stairs of 12 cm in MuJoCo", WALKS, 0.12, simulator="mujoco"),
    "down_12_mujoco": _stairs("down stairs of 12 cm in MuJoCo", WALKS, -0.12, simulator="mujoco"),
    "stairs_fast": _stairs("up stairs of 12 cm, told 0.5 m/s", 0.95, 0.12, speed=0.5),
}


@cache
def walk_on_soles() -> str:
    """Return the scenario of the biped on soles, written for this process."""
    folder = Path(mkdtemp(prefix="linefoot_soles_"))
    atexit.register(rmtree, folder, ignore_errors=True)
    write_folder(folder / "robot", analyse(write_soled(folder, "soles", BIPED, SOLE)))
    found = scenario_beside(robot_file(folder / "robot"))
    assert found is not None
    return found


@dataclass(frozen=True)
class Trial:
    """A run to carry out."""

    case: str
    index: int  # of the seed

    @property
    def key(self) -> str:
        """What makes it one trial."""
        return f"{self.case} {self.index}"


def trials(quick: bool, first: int = FRESH) -> Iterator[Trial]:
    """Yield what there is to try, a run of each case after the other."""
    for run in range(QUICK_RUNS if quick else RUNS):
        yield from (Trial(name, first + run) for name, case in CASES.items() if run < case.runs)


def length_of(course: CourseParameters) -> float:
    """Return how long a course is at most [m]."""
    if isinstance(course, StairsParameters):
        return (course.steps - 1) * course.tread[1]
    if isinstance(course, SpiralParameters):
        return (course.steps - 1) * course.tread
    if isinstance(course, GapsParameters):
        return course.count * course.length + (course.count - 1) * course.land
    if isinstance(course, StonesParameters):
        return course.rows * (course.size + course.gap) + course.gap
    assert isinstance(course, BlocksParameters)
    return course.rows * course.size


def course_of(trial: Trial) -> CourseParameters:
    """Return the course of a trial."""
    case, random = CASES[trial.case], np.random.default_rng([trial.index, *trial.case.encode()])
    most = 0.1 if case.kind is SpiralParameters else HEADING  # along which the robot turns
    at, heading = float(random.uniform(*AT)), float(random.uniform(-most, most))
    given: dict[str, Any] = {"at": at, "heading": heading, **case.numbers}
    if case.kind is StairsParameters:
        given |= {"tread": list(TREAD), "steps": STEPS}
    return case.kind(**given)


def progress(course: CourseParameters, places: Array) -> Array:
    """Return how far places are along a course [m].

    Args:
        course: its middle line; of a spiral stair an arc.
        places: x, y [m], shape (n, 2).

    Returns:
        Shape (n,); negative on the pad.
    """
    c, s = np.cos(course.heading), np.sin(course.heading)
    ahead, left = ((places - [course.at, 0.0]) @ np.array([[c, -s], [s, c]])).T
    if not isinstance(course, SpiralParameters):
        return ahead
    angle, end = np.arctan2(ahead, course.radius - left), length_of(course) / course.radius
    c, s = np.cos(end), np.sin(end)
    beyond = c * ahead + s * (left - course.radius)  # along the landing
    on_steps = np.where(angle <= end, course.radius * angle, course.radius * end + beyond)
    along: Array = np.where(ahead < 0.0, ahead, on_steps)
    return along


def goal_of(course: CourseParameters) -> float:
    """Return how far the torso is to come along a course [m]."""
    return length_of(course) + BEYOND


def scenario(trial: Trial) -> Scenario:
    """Return what is simulated.

    The robot walks straight on, whatever the course's heading; on a spiral stair it turns along.
    """
    case, course = CASES[trial.case], course_of(trial)
    way = (course.at + goal_of(course)) / np.cos(course.heading)
    time = round(SLOWNESS * way / case.speed, 1)
    parts: dict[str, Any] = {NAMES[case.kind]: course}
    segments = [Segment("stand", STAND), Segment("walk", time, True, [case.speed, 0.0])]
    if isinstance(course, SpiralParameters):
        first, turning = (round(x / case.speed, 1) for x in (course.at, length_of(course)))
        rate, rest = case.speed / course.radius, round(time - first - turning, 1)
        segments[1] = replace(segments[1], duration=first)
        for name, duration, turn in (("turn", turning, rate), ("on", rest, 0.0)):
            segments.append(Segment(name, duration, True, [case.speed, 0.0], turn))
    base = load_scenario(walk_on_soles()) if case.on_soles else Scenario()
    made = replace(
        base,
        name=trial.case,
        seed=trial.index,
        ground=replace(base.ground, **parts),
        terrain=case.terrain,
        estimation=case.estimation,
        segments=segments,
        plant=replace(base.plant, simulator=case.simulator),
    )
    if not case.push:
        return made
    random = np.random.default_rng([trial.index, 1])
    when, to = float(random.uniform(*PUSH_TIME)), float(random.uniform(-np.pi, np.pi))
    return replace(made, pushes=[PushParameters(time=when, impulse=case.push, direction=to)])
