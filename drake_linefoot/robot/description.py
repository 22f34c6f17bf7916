"""The description of a humanoid: a YAML file beside its model."""

from __future__ import annotations

import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from drake_linefoot.errors import ModelError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FootDescription:
    """One foot that touches the ground along a line.

    Attributes:
        name: "left" or "right".
        frame: name of the foot's body.
        contact_points: heel and toe in the foot frame [m], shape (2, 3).
        leg_joints: names of the joints from the torso to the foot.
    """

    name: str
    frame: str
    contact_points: Array
    leg_joints: tuple[str, ...]


@dataclass(frozen=True)
class StepLimits:
    """What the gait may ask of the legs, all in m.

    Attributes:
        step_length: largest distance from stance to landing foot along the heading.
        step_width_min: smallest lateral distance between the feet (no crossing).
        step_width_max: largest lateral distance between the feet.
        com_height_min: lowest height of the CoM above the stance foot.
        com_height_max: highest height of the CoM above the stance foot.
    """

    step_length: float
    step_width_min: float
    step_width_max: float
    com_height_min: float
    com_height_max: float


@dataclass(frozen=True)
class HumanoidDescription:
    """What the code needs to know of a robot and cannot read from its model.

    Attributes:
        file: where it was read.
        name: name of the robot.
        model: path of the model file.
        floating_base: name of the torso body.
        actuated_joints: joint names in the order of torques.
        feet: left before right.
        arm_joints: names of the joints the legs do not use.
        mirror: left joint -> (right joint, sign).
        nominal_posture: joint -> angle [rad]; joints not named are at 0.
        limits: what the gait may ask.
    """

    file: Path
    name: str
    model: Path
    floating_base: str
    actuated_joints: tuple[str, ...]
    feet: tuple[FootDescription, FootDescription]
    arm_joints: tuple[str, ...]
    mirror: dict[str, tuple[str, float]]
    nominal_posture: dict[str, float]
    limits: StepLimits = field(repr=False)


class _Reader:
    """Reads entries of one mapping and names file and entry when one is wrong."""

    def __init__(self, file: Path, data: Any, prefix: str = "") -> None:
        if not isinstance(data, dict):
            raise ModelError(file, prefix.rstrip("."), data, "must be a mapping")
        self.file, self.data, self.prefix = file, data, prefix

    def error(self, entry: object, value: object, allowed: str) -> ModelError:
        return ModelError(self.file, f"{self.prefix}{entry}", value, allowed)

    def only(self, known: set[str]) -> None:
        for key in self.data:
            if key not in known:
                raise self.error(key, self.data[key], f"unknown entry; known: {sorted(known)}")

    def get(self, entry: str) -> Any:
        if entry not in self.data:
            raise self.error(entry, None, "is missing")
        return self.data[entry]

    def text(self, entry: str) -> str:
        value = self.get(entry)
        if not isinstance(value, str) or not value:
            raise self.error(entry, value, "must be a name")
        return value

    def number(self, entry: str) -> float:
        value = self.get(entry)
        if not _is_number(value):
            raise self.error(entry, value, "must be a finite number")
        return float(value)

    def names(self, entry: str) -> tuple[str, ...]:
        value = self.get(entry)
        if not isinstance(value, list) or not all(isinstance(v, str) for v in value):
            raise self.error(entry, value, "must be a list of names")
        if len(set(value)) != len(value):
            raise self.error(entry, value, "must not repeat a name")
        return tuple(value)


def _is_number(value: object) -> bool:
    """Whether a value of a file is a number that a float can hold."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return abs(value) <= sys.float_info.max  # False for NaN as well


def _read_foot(file: Path, data: Any, side: str, number: int) -> FootDescription:
    """Read one entry of `feet`."""
    r = _Reader(file, data, f"feet[{number}].")
    r.only({"name", "frame", "contact_points", "leg_joints"})
    if r.text("name") != side:
        raise r.error("name", r.text("name"), f"must be {side!r} (left before right)")
    points = r.get("contact_points")
    good = isinstance(points, list) and len(points) == 2
    good = good and all(isinstance(point, list) and len(point) == 3 for point in points)
    if not good or not all(_is_number(value) for point in points for value in point):
        raise r.error("contact_points", points, "must be two points [x, y, z], heel before toe")
    p = np.array(points, dtype=float)
    if not p[1, 0] > p[0, 0] or p[0, 1] != p[1, 1] or p[0, 2] != p[1, 2]:
        raise r.error("contact_points", points, "must lie along +x of the foot, heel before toe")
    p.setflags(write=False)
    return FootDescription(side, r.text("frame"), p, r.names("leg_joints"))


def _read_mirror(r: _Reader, joints: tuple[str, ...]) -> dict[str, tuple[str, float]]:
    """Read the mirror map; together with its partners it must name every joint once."""
    mirror: dict[str, tuple[str, float]] = {}
    data = r.get("mirror")
    if not isinstance(data, dict):
        raise r.error("mirror", data, "must map a left joint to [right joint, sign]")
    for left, pair in data.items():
        good = isinstance(pair, list) and len(pair) == 2 and isinstance(pair[0], str)
        if not good or not _is_number(pair[1]) or abs(pair[1]) != 1:
            raise r.error(f"mirror.{left}", pair, "must be [right joint, 1 or -1]")
        mirror[str(left)] = (pair[0], float(pair[1]))
    named = sorted([*mirror, *(right for right, _ in mirror.values())])
    if named != sorted(joints):
        wrong = sorted(set(named) ^ set(joints))
        raise r.error("mirror", wrong, "must name every actuated joint once, left or right")
    return mirror


def _read_limits(file: Path, data: Any) -> StepLimits:
    """Read the step limits; every one must be positive, minima below maxima."""
    r = _Reader(file, data, "limits.")
    names = list(StepLimits.__dataclass_fields__)
    r.only(set(names))
    values = {name: r.number(name) for name in names}
    for name, value in values.items():
        if value <= 0.0:
            raise r.error(name, value, "must be positive")
    for low, high in (("step_width_min", "step_width_max"), ("com_height_min", "com_height_max")):
        if values[low] >= values[high]:
            raise r.error(low, values[low], f"must be below {high} = {values[high]}")
    return StepLimits(**values)


def load_description(file: str | Path) -> HumanoidDescription:
    """Read and check a description.

    Args:
        file: path of the YAML file.

    Returns:
        The description; names are checked against the model only by `Humanoid`.

    Raises:
        ModelError: the file is missing, is no YAML, or an entry is missing or wrong.
    """
    file = Path(file)
    try:
        data = yaml.safe_load(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise ModelError(file, "", "robot description", f"cannot be read: {error}") from error
    except (yaml.YAMLError, ValueError) as error:  # a date or an encoding is a ValueError
        reason = str(error).replace("\n", " ")
        raise ModelError(file, "", "robot description", f"is no YAML: {reason}") from error
    r = _Reader(file, data)
    r.only(set(HumanoidDescription.__dataclass_fields__) - {"file"})
    joints = r.names("actuated_joints")
    feet = r.get("feet")
    if not isinstance(feet, list) or len(feet) != 2:
        raise r.error("feet", feet, "must be a list of two feet, left before right")
    posture = _Reader(file, r.get("nominal_posture"), "nominal_posture.")
    for name in posture.data:
        if name not in joints:
            raise posture.error(name, posture.data[name], "is not an actuated joint")
    return HumanoidDescription(
        file=file,
        name=r.text("name"),
        model=file.parent / r.text("model"),
        floating_base=r.text("floating_base"),
        actuated_joints=joints,
        feet=(_read_foot(file, feet[0], "left", 0), _read_foot(file, feet[1], "right", 1)),
        arm_joints=r.names("arm_joints"),
        mirror=_read_mirror(r, joints),
        nominal_posture={name: posture.number(name) for name in posture.data},
        limits=_read_limits(file, r.get("limits")),
    )
