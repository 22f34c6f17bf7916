"""The description of a humanoid: a YAML file beside its model."""

import os
import sys
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator, PlainValidator

from drake_linefoot.checks import check, shown
from drake_linefoot.errors import ModelError
from drake_linefoot.fields import (
    Name,
    NotNegative,
    Number,
    Positive,
    Triple,
    Unit,
    misfit,
    one_of,
    together,
)
from drake_linefoot.resources import robot_files, shipped_or_path
from drake_linefoot.types import Array
from drake_linefoot.yaml_file import read_yaml

SIDES = ("left", "right")
LINE, SURFACE = "line", "surface"
SCENARIO = "walk.yaml"  # that walks a robot, in the folder of its description
_SAME = 1e-9  # [m] by which what should be equal may differ in a file
_ALIKE = 1e-6  # [-] by which the lengths of both feet may differ, and their widths


def _is_number(value: object) -> bool:
    """Whether a value of a file is a number that a float can hold."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return abs(value) <= sys.float_info.max  # False for NaN as well


def _is_point(value: object) -> bool:
    return isinstance(value, list) and len(value) == 3 and all(map(_is_number, value))


def _contact_points(value: object) -> Array:
    if not (isinstance(value, list) and len(value) == 2 and all(map(_is_point, value))):
        raise ValueError("must be two points [x, y, z], heel before toe")
    points = np.array(value, dtype=float)
    heel, toe = points
    if not toe[0] > heel[0] or not np.allclose(toe[1:], heel[1:], rtol=0, atol=_SAME):
        raise ValueError("must lie along +x of the foot, heel before toe")
    points.setflags(write=False)
    return points


def _names(value: object) -> tuple[str, ...]:
    if not isinstance(value, list) or not all(isinstance(name, str) for name in value):
        raise ValueError("must be a list of names")
    if len(set(value)) != len(value):
        raise ValueError("must not repeat a name")
    return tuple(value)


def _mirrored(value: object) -> tuple[str, float]:
    if isinstance(value, list) and len(value) == 2:
        joint, sign = value
        if isinstance(joint, str) and _is_number(sign) and abs(sign) == 1:
            return joint, float(sign)
    raise ValueError("must be [right joint, 1 or -1]")


def _path(value: object) -> Path:
    if not isinstance(value, str) or not value:
        raise ValueError("must be the name of a file")
    return Path(value)


def _contact(value: object) -> object:
    if value == "point":
        raise ValueError(f"must be {LINE} or {SURFACE}: on points a robot cannot stand still")
    return value


def _feet(value: object) -> list[Any]:
    if not isinstance(value, list) or len(value) != len(SIDES):
        raise ValueError("must be a list of two feet, left before right")
    return value


Names = Annotated[tuple[str, ...], PlainValidator(_names)]
Length = Annotated[Positive, Unit("m")]


@dataclass(frozen=True)
class PoseDescription:
    """Where a frame is in that of a body."""

    rpy: Annotated[Triple, Unit("rad")] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    """Roll, pitch and yaw as in URDF: about x, then y, then z of the body."""
    xyz: Annotated[Triple, Unit("m")] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    """Origin."""


@dataclass(frozen=True)
class FootDescription:
    """One foot that touches the ground along a line, or with a sole that has a width."""

    name: str
    """"left" or "right"."""
    frame: Name
    """Name of the foot's body."""
    contact_points: Annotated[Array, PlainValidator(_contact_points), Unit("m")]
    """Heel and toe in the foot frame, in the middle of the sole, shape (2, 3)."""
    leg_joints: Names
    """Names of the joints from the torso to the foot."""
    pose: PoseDescription | None = None
    """Of the foot frame in `frame`; None: that frame itself."""
    contact_width: Length | None = None
    """Of the sole, where the contact is a surface; None for a line."""

    @property
    def halves(self) -> tuple[float, float]:
        """Half of length and width [m]; the width of a line is 0."""
        length: float = (0.5 * (self.contact_points[1, 0] - self.contact_points[0, 0])).tolist()
        return length, 0.5 * (self.contact_width or 0.0)

    @property
    def ground_points(self) -> Array:
        """Where the foot touches flat ground, in the foot frame [m], shape (n, 3).

        Heel and toe of a line; of a surface heel left, heel right, toe left, toe right.
        """
        if self.contact_width is None:
            return self.contact_points
        across = np.array([0.0, 0.5 * self.contact_width, 0.0])
        return np.concatenate([[p + across, p - across] for p in self.contact_points])


@dataclass(frozen=True)
class StepLimits:
    """What the gait may ask of the legs."""

    step_length: Length
    """Largest distance from stance to landing foot along the heading."""
    step_width_min: Length
    """Smallest lateral distance between the feet (no crossing)."""
    step_width_max: Length
    """Largest lateral distance between the feet."""
    com_height_min: Length
    """Lowest height of the CoM above the stance foot."""
    com_height_max: Length
    """Highest height of the CoM above the stance foot."""
    swing_height_max: Length | None = None
    """Highest apex of a swing at which no joint comes to its stop; None: that of a default."""

    @together
    def _minima_below_maxima(self) -> None:
        for low, high in (
            ("step_width_min", "step_width_max"),
            ("com_height_min", "com_height_max"),
        ):
            if getattr(self, low) >= getattr(self, high):
                allowed = f"must be below {high} = {getattr(self, high)}"
                raise misfit(low, getattr(self, low), allowed)


@dataclass(frozen=True)
class HumanoidDescription:
    """What the code needs to know of a robot and cannot read from its model."""

    file: Path
    """Where it was read."""
    name: Name
    """Name of the robot."""
    model: Annotated[Path, PlainValidator(_path)]
    """Path of the model file."""
    floating_base: Name
    """Name of the torso body."""
    feet: Annotated[tuple[FootDescription, FootDescription], BeforeValidator(_feet)]
    """Left before right."""
    nominal_posture: Annotated[dict[Any, Number], Unit("rad")]
    """Joint -> angle; joints not named are at 0."""
    limits: StepLimits = field(repr=False)
    """What the gait may ask."""
    contact: Annotated[str, one_of((LINE, SURFACE)), BeforeValidator(_contact)] = LINE
    """"line": feet touch along a line and have no ankle roll; "surface": with a sole that has a
    width, and turn about all axes."""
    contact_margin: Annotated[NotNegative, Unit("m")] = 0.0
    """What the contact cones leave of the sole at each edge."""
    lock: Annotated[dict[Any, Number], Unit("rad")] = field(default_factory=dict)
    """Joint -> angle at which it is welded."""
    floating_base_pose: PoseDescription | None = None
    """Of frame B, x ahead and z up, in the torso body; None: the body's own frame."""
    actuated_joints: Names = ()
    """Joint names in the order of torques; none: as the model has them."""
    arm_joints: Names = ()
    """Names of the joints the legs do not use; none: all those."""
    mirror: dict[Any, Annotated[tuple[str, float], PlainValidator(_mirrored)]] = field(
        default_factory=dict
    )
    """Left joint -> (right joint, sign); none: as their places and axes say."""

    def refuse(self, entry: str, value: object, allowed: str) -> ModelError:
        """Return the error of an entry that does not fit the model."""
        return ModelError(self.file, entry, value, allowed)

    @together
    def _agrees(self) -> None:
        for i, (foot, side) in enumerate(zip(self.feet, SIDES, strict=True)):
            if foot.name != side:
                raise misfit(f"feet[{i}].name", foot.name, f"must be {side!r} (left before right)")
            self._check_sole(f"feet[{i}]", foot)
        both = zip(*(foot.halves for foot in self.feet), strict=True)
        for entry, sizes in zip(("contact_points", "contact_width"), both, strict=True):
            if abs(sizes[0] - sizes[1]) > _ALIKE * max(sizes):
                allowed = "both feet must be equally long and wide"
                raise misfit(f"feet[1].{entry}", list(sizes), allowed)
        if self.actuated_joints:
            self._check_names()

    def _check_sole(self, entry: str, foot: FootDescription) -> None:
        width = foot.contact_width
        if (width is None) != (self.contact == LINE):
            allowed = (
                f"must be given where contact is {SURFACE}, and only there: it is {self.contact}"
            )
            raise misfit(f"{entry}.contact_width", width, allowed)
        least = min(half for half in foot.halves if half)
        if self.contact_margin >= least:
            allowed = f"must be less than half of length and width of {entry}: {least:g}"
            raise misfit("contact_margin", self.contact_margin, allowed)

    def _check_names(self) -> None:
        for name, angle in self.nominal_posture.items():
            if name not in self.actuated_joints:
                raise misfit(f"nominal_posture.{name}", angle, "is not an actuated joint")
        if not self.mirror:
            return
        lefts = {str(left): right for left, (right, _) in self.mirror.items()}
        named = [*lefts, *(right for left, right in lefts.items() if right != left)]
        if sorted(named) != sorted(self.actuated_joints):
            wrong = sorted(set(named) ^ set(self.actuated_joints))
            allowed = "must name every actuated joint once, left or right"
            raise misfit("mirror", wrong, allowed)


def robot_file(robot: str | Path) -> Path:
    """Return the description of a robot.

    Args:
        robot: the name of a shipped one, the folder that `linefoot new-robot` wrote, or the file.

    Raises:
        ModelError: there is none of that name, or not one description in the folder.
    """
    shipped = robot_files()
    path = shipped_or_path(str(robot), shipped)
    if path is None:
        allowed = f"is no folder that is there, no .yaml file, and none of {list(shipped)}"
        raise ModelError("robot", "", str(robot), allowed)
    if not os.path.isdir(path):
        return path
    files = sorted(set(path.glob("*.yaml")) - {path / SCENARIO})
    if len(files) != 1:
        allowed = f"must be a folder with one description beside {SCENARIO}"
        raise ModelError(path, "", [file.name for file in files], allowed)
    return files[0]


def load_description(file: str | Path) -> HumanoidDescription:
    """Read and check a YAML file; its names are checked against the model only by `Humanoid`.

    Raises:
        ModelError: the file is missing, is no YAML, or an entry is missing or wrong.
    """
    file = Path(file)
    data = read_yaml(file, "robot description", ModelError)
    if isinstance(data, dict):
        if "file" in data:
            raise ModelError(file, "file", shown(data["file"]), "unknown field")
        data = {"file": file, **data}
    description = check(data, HumanoidDescription, file, error=ModelError)
    return replace(description, model=file.parent / description.model)
