"""What is tried on known ground: cases, their bars, and the scenario of each trial."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.scenario.courses import (
    BlocksParameters,
    CourseParameters,
    GapsParameters,
    StairsParameters,
    StonesParameters,
    TerrainParameters,
)
from drake_linefoot.lab.scenario.disturbances import GroundParameters, PushParameters

STAND = 0.5  # [s] before anything
RUNS, QUICK_RUNS = 200, 2  # of each case
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
}
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


def _stairs(what: str, bar: float, rise: float, **changes: Any) -> Case:
    speed = SLOW if rise < -0.13 else SPEED
    return Case(what, bar, StairsParameters, {"rise": rise}, **{"speed": speed, **changes})


OFF_MAP = TerrainParameters("scene", noise=OFF, error=OFF)
CASES = {
    "stairs_up_12": _stairs("up stairs of 12 cm", 0.95, 0.12),
    "stairs_down_12": _stairs("down stairs of 12 cm", 0.95, -0.12),
    "stairs_up_15": _stairs("up stairs of 15 cm", 0.85, 0.15),
    "stairs_down_15": _stairs("down stairs of 15 cm", 0.75, -0.15),
    "up_12_map_off": _stairs("with a map off by up to 2 cm", 0.9, 0.12, terrain=OFF_MAP),
    "down_12_map_off": _stairs("with a map off by up to 2 cm", 0.9, -0.12, terrain=OFF_MAP),
    "up_12_estimate": _stairs("on the estimate", 0.9, 0.12, estimation=True),
    "down_12_estimate": _stairs("on the estimate", 0.9, -0.12, estimation=True),
    "up_12_push": _stairs("with a push of 10 N s", 0.85, 0.12, push=PUSH),
    "down_12_push": _stairs("with a push of 10 N s", 0.85, -0.12, push=PUSH),
    "gaps_20": Case("over gaps of 20 cm", 0.95, GapsParameters),
    "stones": Case("on stones of 25 x 25 cm, 10 cm apart", 0.9, StonesParameters),
    "blocks": Case("on blocks of +-5 cm and 10 degrees", 0.95, BlocksParameters),
    "stairs_fast": _stairs("up stairs of 12 cm at 0.45 m/s", 0.95, 0.12, speed=0.5),
}


@dataclass(frozen=True)
class Trial:
    """A run to carry out."""

    case: str
    index: int  # of the seed

    @property
    def key(self) -> str:
        """What makes it one trial."""
        return f"{self.case} {self.index}"


def trials(quick: bool) -> Iterator[Trial]:
    """Yield what there is to try, a run of each case after the other."""
    for index in range(QUICK_RUNS if quick else RUNS):
        yield from (Trial(case, index) for case in CASES)


def length_of(course: CourseParameters) -> float:
    """Return how long a course is at most [m]."""
    if isinstance(course, StairsParameters):
        return (course.steps - 1) * course.tread[1]
    if isinstance(course, GapsParameters):
        return course.count * course.length + (course.count - 1) * course.land
    if isinstance(course, StonesParameters):
        return course.rows * (course.size + course.gap) + course.gap
    assert isinstance(course, BlocksParameters)
    return course.rows * course.size


def course_of(trial: Trial) -> CourseParameters:
    """Return the course of a trial."""
    case, random = CASES[trial.case], np.random.default_rng([trial.index, *trial.case.encode()])
    at, heading = float(random.uniform(*AT)), float(random.uniform(-HEADING, HEADING))
    given: dict[str, Any] = {"at": at, "heading": heading, **case.numbers}
    if case.kind is StairsParameters:
        given |= {"tread": list(TREAD), "steps": STEPS}
    return case.kind(**given)


def goal_of(course: CourseParameters) -> float:
    """Return how far the torso is to come along a course [m]."""
    return length_of(course) + BEYOND


def scenario(trial: Trial) -> Scenario:
    """Return what is simulated: the robot walks straight on, whatever the course's heading."""
    case, course = CASES[trial.case], course_of(trial)
    way = (course.at + goal_of(course)) / np.cos(course.heading)
    time = round(SLOWNESS * way / case.speed, 1)
    parts: dict[str, Any] = {NAMES[case.kind]: course}
    made = Scenario(
        name=trial.case,
        seed=trial.index,
        ground=GroundParameters(**parts),
        terrain=case.terrain,
        estimation=case.estimation,
        segments=[Segment("stand", STAND), Segment("walk", time, True, [case.speed, 0.0])],
    )
    if not case.push:
        return made
    random = np.random.default_rng([trial.index, 1])
    when, to = float(random.uniform(*PUSH_TIME)), float(random.uniform(-np.pi, np.pi))
    return replace(made, pushes=[PushParameters(time=when, impulse=case.push, direction=to)])
