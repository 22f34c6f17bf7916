"""What the values of a scenario must be. Cheap: reads descriptions, builds no plant."""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

from drake_linefoot.contact.cone_program import SOLVERS
from drake_linefoot.contact.parameters import METHODS
from drake_linefoot.errors import LinefootError, ScenarioError
from drake_linefoot.mpc.parameters import MODELS
from drake_linefoot.mpc.solve import MPC_SOLVERS
from drake_linefoot.resources import models_dir
from drake_linefoot.robot.description import HumanoidDescription, load_description
from drake_linefoot.scenario import Scenario, Segment
from drake_linefoot.scenario_types import leaves, shown
from drake_linefoot.simulation.scene import load_scene, scene_of

SHORTEST_TICK = 0.001  # [s]
TICKS = (SHORTEST_TICK, 0.002)  # [s] of plant, estimator, gait and whole-body controller


@dataclasses.dataclass(frozen=True)
class Rule:
    """A condition on one number, and how to say it."""

    holds: Callable[[float], bool]
    allowed: str


ANY = Rule(lambda x: True, "")
POSITIVE = Rule(lambda x: x > 0.0, "must be positive")
NOT_NEGATIVE = Rule(lambda x: x >= 0.0, "must not be negative")
FRACTION = Rule(lambda x: 0.0 <= x <= 1.0, "must lie in [0, 1]")
AT_LEAST_ONE = Rule(lambda x: x >= 1, "must be at least 1")
A_TICK_OR_MORE = Rule(lambda x: x >= SHORTEST_TICK, "must be at least 0.001 s")
TICK = Rule(lambda x: x in TICKS, "must be 0.001 or 0.002 s, the period of the whole controller")

# Every number that is not named here must not be negative.
RULES = {
    "segments[].duration": POSITIVE,
    "segments[].velocity[]": ANY,
    "segments[].turn_rate": ANY,
    "ground.slope_heading": ANY,
    "ground.ledge_height": ANY,
    "error.torso_mass": ANY,
    "error.leg_mass_scale": POSITIVE,
    "error.torso_com[]": ANY,
    "actuators.base_speed_share": Rule(lambda x: 0.0 <= x < 1.0, "must lie in [0, 1)"),
    "actuators.delay": Rule(lambda x: 0.0 <= x <= 0.006, "must lie in [0, 0.006] s"),
    "pushes[].duration": A_TICK_OR_MORE,
    "pushes[].direction": ANY,
    "plant.time_step": TICK,
    "estimator.filter_constant": Rule(lambda x: 0.0 <= x < 1.0, "must lie in [0, 1)"),
    "estimator.touch_force": POSITIVE,
    "estimator.friction": POSITIVE,
    "gait.single_support": A_TICK_OR_MORE,
    "gait.double_support": A_TICK_OR_MORE,
    "gait.step_length": POSITIVE,
    "gait.single_support_min": A_TICK_OR_MORE,
    "gait.shift_duration": A_TICK_OR_MORE,
    "gait.swing_height": POSITIVE,
    "gait.linear_acceleration": POSITIVE,
    "gait.angular_acceleration": POSITIVE,
    "gait.capture_rate": POSITIVE,
    "gait.speed_scale[]": POSITIVE,
    "gait.speed_learning": FRACTION,
    "gait.speed_scale_max": AT_LEAST_ONE,
    "gait.early_contact_phase": FRACTION,
    "gait.contact_speed": POSITIVE,
    "gait.reach_speed": POSITIVE,
    "gait.slope_max": FRACTION,
    "gait.reach_forward": POSITIVE,
    "gait.reach_outward": POSITIVE,
    "gait.closing_tolerance": POSITIVE,
    "mpc.knots": Rule(lambda x: 1 <= x <= 200, "must lie in [1, 200]"),
    "mpc.knot_step": A_TICK_OR_MORE,
    "mpc.period": A_TICK_OR_MORE,
    "mpc.friction": POSITIVE,
    "mpc.weights.force": POSITIVE,
    "mpc.weights.torque": POSITIVE,
    "mpc.tolerance": POSITIVE,
    "mpc.max_iterations": AT_LEAST_ONE,
    "wbc.force_error_weight": POSITIVE,
    "wbc.torque_error_weight": POSITIVE,
    "wbc.friction": POSITIVE,
    "wbc.tolerance": POSITIVE,
    "wbc.max_iterations": AT_LEAST_ONE,
}
CHOICES = {
    "plant.contact_approximation": ("lagged", "similar", "sap", "tamsi"),
    "estimator.method": METHODS,
    "gait.first_swing": ("left", "right"),
    "mpc.model": MODELS,
    "mpc.solver": MPC_SOLVERS,
    "wbc.solver": SOLVERS,
}


def check_rules(scenario: Scenario, file: str | Path) -> None:
    """Check every value of a scenario whose types are right.

    Raises:
        ScenarioError: a value is not usable.
    """
    for entry, value in leaves(scenario):
        _check_leaf(entry, value, file)
    _check_lengths(scenario, "", file)
    if not scenario.segments:
        raise ScenarioError(file, "segments", [], "must have at least one segment")
    for i, segment in enumerate(scenario.segments):
        _check_segment(segment, f"segments[{i}]", file)
    for i, push in enumerate(scenario.pushes):
        _check_multiple(push.duration, f"pushes[{i}].duration", scenario, file)
    _check_multiple(scenario.actuators.delay, "actuators.delay", scenario, file)
    _check_estimator(scenario, file)
    _check_periods(scenario, file)
    _check_gait(scenario, _description(scenario.robot, file), file)
    _check_scene(scenario, file)


def _check_leaf(entry: str, value: object, file: str | Path) -> None:
    """Check one number or text by itself."""
    key = re.sub(r"\[\d+\]", "[]", entry)
    if isinstance(value, bool):
        return
    if isinstance(value, str):
        choices = CHOICES.get(key)
        if choices and value not in choices:
            raise ScenarioError(file, entry, shown(value), f"must be one of {list(choices)}")
        if not (value and value.isprintable()):
            raise ScenarioError(file, entry, shown(value), "must be a name, on one line")
    elif isinstance(value, int | float):
        if not math.isfinite(value):
            raise ScenarioError(file, entry, value, "must be a finite number")
        rule = RULES.get(key, NOT_NEGATIVE)
        if not rule.holds(value):
            raise ScenarioError(file, entry, shown(value), rule.allowed)


def _check_lengths(part: Any, entry: str, file: str | Path) -> None:
    """Check that every list of numbers is as long as in the defaults."""
    default = type(part)()
    for field in dataclasses.fields(part):
        value, at = getattr(part, field.name), f"{entry}.{field.name}" if entry else field.name
        if dataclasses.is_dataclass(value):
            _check_lengths(value, at, file)
        elif field.type == list[float]:
            length = len(getattr(default, field.name))
            if len(value) != length:
                raise ScenarioError(file, at, shown(value), f"must be a list of {length} numbers")


def _check_segment(segment: Segment, entry: str, file: str | Path) -> None:
    """Check that a segment says one thing."""
    _check_lengths(segment, entry, file)
    if not segment.walk and (any(segment.velocity) or segment.turn_rate):
        allowed = "must be true in a segment with a velocity or a turn rate"
        raise ScenarioError(file, f"{entry}.walk", segment.walk, allowed)


def _check_estimator(scenario: Scenario, file: str | Path) -> None:
    release, touch = scenario.estimator.release_force, scenario.estimator.touch_force
    if release >= touch:
        allowed = f"must be below touch_force = {touch}"
        raise ScenarioError(file, "estimator.release_force", release, allowed)


def _check_periods(scenario: Scenario, file: str | Path) -> None:
    """Check that plans come at ticks: events that nearly coincide have no certain order."""
    _check_multiple(scenario.mpc.period, "mpc.period", scenario, file)


def _check_multiple(value: float, entry: str, scenario: Scenario, file: str | Path) -> None:
    """Check that a time is a whole number of ticks."""
    tick = scenario.plant.time_step
    if abs(value / tick - round(value / tick)) > 1e-6:
        allowed = f"must be a multiple of {tick:g} s, plant.time_step"
        raise ScenarioError(file, entry, value, allowed)


def _check_gait(scenario: Scenario, robot: HumanoidDescription, file: str | Path) -> None:
    """Check the gait against itself and against the robot's step limits."""
    gait, limits = scenario.gait, robot.limits
    still = gait.settle_time + gait.freeze_time
    for name in ("single_support", "single_support_min"):
        if getattr(gait, name) <= still:
            allowed = f"must be above settle_time + freeze_time = {still:g}"
            raise ScenarioError(file, f"gait.{name}", getattr(gait, name), allowed)
    ranges = {
        "step_width": (limits.step_width_min, limits.step_width_max),
        "com_height": (limits.com_height_min, limits.com_height_max),
    }
    for name, (low, high) in ranges.items():
        value = getattr(gait, name)
        if not low <= value <= high:
            allowed = f"must lie in [{low}, {high}], the limits of {robot.name}"
            raise ScenarioError(file, f"gait.{name}", value, allowed)


def _description(name: str, file: str | Path) -> HumanoidDescription:
    """Read the description of the robot, without its model."""
    shipped = sorted(path.parent.name for path in models_dir().glob("*/*.urdf"))
    if name in shipped:
        path = models_dir() / name / f"{name}.yaml"
    elif name.endswith((".yaml", ".yml")):
        path = Path(name)
    else:
        allowed = f"unknown robot; must be one of {shipped}, or a .yaml file"
        raise ScenarioError(file, "robot", shown(name), allowed)
    try:
        return load_description(path)
    except LinefootError as error:
        raise ScenarioError(file, "robot", shown(name), f"not usable: {error}") from error


def _check_scene(scenario: Scenario, file: str | Path) -> None:
    """Read the scene, and check it with the scenario's own numbers."""
    name = scenario.scene
    shipped = sorted(path.stem for path in models_dir().glob("scenes/*.yaml"))
    if name not in shipped and not name.endswith((".yaml", ".yml")):
        allowed = f"unknown scene; must be one of {shipped}, or a .yaml file"
        raise ScenarioError(file, "scene", shown(name), allowed)
    try:
        load_scene(name)
    except (LinefootError, OSError) as error:
        raise ScenarioError(file, "scene", shown(name), f"not usable: {error}") from error
    scene_of(scenario).validate(file, "ground.")
