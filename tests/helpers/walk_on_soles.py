"""A short walk of a robot on soles, simulated once."""

from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import mkdtemp

from drake_linefoot.lab.new_robot.analysis import analyse
from drake_linefoot.lab.new_robot.folder import scenario_beside, write_folder
from drake_linefoot.lab.scenario import Segment
from drake_linefoot.lab.scenario.load import load_scenario
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.robot.description import robot_file
from drake_linefoot.robot.humanoid import load_humanoid
from tests.helpers.sole_biped import write_sole_biped

STEP = [Segment("stand", 0.8), Segment("step", 1.0, True, [0.1, 0.0])]


@cache
def robot_on_soles():
    """The robot, and what is simulated: on the estimate, it stands and takes some steps."""
    folder = Path(mkdtemp(prefix="soles_"))
    write_folder(folder / "robot", analyse(write_sole_biped(folder)))
    file = robot_file(folder / "robot")
    scenario = replace(load_scenario(scenario_beside(file)), segments=STEP, estimation=True)
    return load_humanoid(file), scenario


@cache
def walk_on_soles():
    """The run."""
    return simulate(build_closed_loop(robot_on_soles()[1]))
