"""Whether a scenario can be run. Cheap: reads descriptions, builds no plant."""

from pathlib import Path

from drake_linefoot.checks import check, plain
from drake_linefoot.errors import ScenarioError
from drake_linefoot.fields import OfRobot
from drake_linefoot.resources import robot_files
from drake_linefoot.robot.description import HumanoidDescription, load_description
from drake_linefoot.scenario.scene import read_part, scene_of
from drake_linefoot.scenario.schema import Scenario


def validate(scenario: Scenario, file: str | Path = "scenario") -> None:
    """Check a scenario without building anything, wherever its values have come from.

    Args:
        scenario: what to check.
        file: what errors call it.

    Raises:
        ScenarioError: a field is not usable; the message names it and what is allowed.
    """
    check(plain(scenario), Scenario, file)
    scene_of(scenario, file)
    check_limits(
        scenario, read_part("robot", scenario.robot, robot_files(), load_description, file), file
    )


def check_limits(
    scenario: Scenario, robot: HumanoidDescription, file: str | Path = "scenario"
) -> None:
    """Check the gait against the limits of a robot, but for defaults that have no size yet.

    Raises:
        ScenarioError: the gait stands too high, too low, too wide or too narrow.
    """
    limits, gait = robot.limits, scenario.gait
    for name, value, low, high in (
        ("step_width", gait.step_width, limits.step_width_min, limits.step_width_max),
        ("com_height", gait.com_height, limits.com_height_min, limits.com_height_max),
    ):
        if not (isinstance(value, OfRobot) or low <= value <= high):
            allowed = f"must lie in [{low}, {high}], the limits of {robot.name}"
            raise ScenarioError(file, f"gait.{name}", value, allowed)
