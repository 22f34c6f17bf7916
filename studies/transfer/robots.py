"""Robots that walk in both simulators, each described from its model alone.

Those of the zoo, and one whose makers publish it for MuJoCo, which walks there as it is as well.
"""

import shutil
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

from drake_linefoot.errors import ModelError
from drake_linefoot.lab.new_robot.analysis import analyse
from drake_linefoot.lab.new_robot.folder import first_speed, write_folder
from drake_linefoot.lab.results.judge import upright
from drake_linefoot.lab.scenario.load import load_scenario
from drake_linefoot.robot.description import LINE, SCENARIO, SURFACE
from drake_linefoot.robot.scaling import units_of
from studies.common.paired import SIMULATORS
from studies.common.trial import outcome_of, walk
from studies.common.types import Data
from studies.zoo.robots import G1, make, published

MADE, OTHERS = ("half_mass", "long_legs", "no_arms", "soled_60"), (G1, "talos_reduced")
TIME, QUICK_TIME = 5.0, 2.0  # [s] of a robot of the MIT Humanoid's size
PACKAGE, MJCF = "robosuite-models", "robosuite_models/assets/robots/h1/robot.xml"  # from PyPI
H1, AS_IT_IS = "h1", "mujoco, its own MJCF"  # masses, joints and contacts of the file
SCENE = """<mujoco>
  <include file="{robot}"/>
  <worldbody><geom type="plane" size="0 0 0.05"/></worldbody>
</mujoco>
"""


@dataclass(frozen=True)
class Robot:
    """A robot in a simulator."""

    name: str
    simulator: str  # or `AS_IT_IS`
    time: float  # in the size of the MIT Humanoid [s]


def robots(quick: bool) -> list[Robot]:
    """Return what is tried; robots of others where their package is installed."""
    files, time = models(), QUICK_TIME if quick else TIME
    names = MADE[:1] if quick else [*MADE, *(name for name in (*OTHERS, H1) if name in files)]
    return [
        Robot(name, simulator, time)
        for name in names
        for simulator in (*SIMULATORS, *([AS_IT_IS] if name == H1 else []))
    ]


def models() -> dict[str, Path]:
    """Return the files of models of others, by name, of packages that are installed."""
    files, _ = published()
    try:
        return {**files, H1: Path(str(distribution(PACKAGE).locate_file(MJCF)))}
    except PackageNotFoundError:
        return files


def scene(model: Path, folder: Path) -> str:
    """Copy an MJCF and its meshes into a folder; return a file of it on level ground."""
    shutil.copytree(model.parent, folder)
    file = folder / "scene.xml"
    file.write_text(SCENE.format(robot=model.name), encoding="utf-8")
    return str(file)


def walked(robot: Robot) -> Data:
    """Walk a robot ahead, as fast as its first walk is, on its soles where it has some.

    Returns:
        `name`, `simulator`, `contact`; `upright`, `reason` why not; `speed`: commanded, and
        `error`: its largest error [m/s], None after a fall.
    """
    files = models()
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) / "robot"
        try:
            found = analyse(files.get(robot.name) or make(robot.name, Path(scratch)))
        except ModelError as error:
            return missed(robot, str(error))
        write_folder(folder, found)
        base, humanoid = load_scenario(str(folder / SCENARIO)), found.humanoid
        speed, time = first_speed(humanoid.com_height), robot.time * units_of(humanoid)["s"]
        made = walk(base, (speed, 0.0, 0.0), round(time, 1))
        plant = replace(made.plant, simulator=robot.simulator.partition(",")[0])
        if robot.simulator == AS_IT_IS:
            file = scene(files[robot.name], Path(scratch) / "mjcf")
            plant = replace(plant, mujoco=replace(plant.mujoco, mjcf=file))
        made = replace(made, plant=plant)
        outcome = outcome_of(made)
    stays = upright(outcome)
    return {
        **missed(robot, "" if stays else outcome["fall_reason"] or outcome["cause"]),
        "contact": SURFACE if humanoid.half_width > 0.0 else LINE,
        "upright": stays,
        "speed": speed,
        "error": outcome["speed_error"] if stays else None,
    }


def missed(robot: Robot, error: str) -> Data:
    """Return what stands for `walked` of a robot whose process crashed or took too long."""
    nothing = {"contact": "", "upright": False, "speed": None, "error": None}
    return {"name": robot.name, "simulator": robot.simulator, "reason": error, **nothing}


def in_both(rows: Sequence[Data]) -> list[str]:
    """Return which robots stayed upright in each simulator."""
    names = dict.fromkeys(row["name"] for row in rows)
    return [name for name in names if all(row["upright"] for row in rows if row["name"] == name)]
