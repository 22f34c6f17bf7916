"""The folder of a robot: a description, and a scenario that walks it."""

import math
import os
import tempfile
from pathlib import Path
from typing import Any

import yaml

from drake_linefoot.errors import OutputError
from drake_linefoot.files import writing
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.lab.new_robot.analysis import Finding
from drake_linefoot.robot.description import SCENARIO
from drake_linefoot.robot.scaling import scaled, units_of

SPEED, SPEED_HEIGHT = 0.3, 0.65  # [m/s] of a robot with its CoM so high [m]
STIFFNESS = 5.0e5  # [N/m] of the ground under an end of a line of the MIT Humanoid
LINE_POINTS = 2
_FIRST = ("lock", "nominal_posture", "limits", "contact_margin")  # what one may want to edit
_HEAD = """# {name}, described by `linefoot new-robot` from the model below. Units: m and rad.
# To edit: lock (joints that are welded at an angle), nominal_posture, limits (what the gait may
# ask){margin}; see docs/add_robot.md. The rest follows from the model.
"""
_MARGIN = ", contact_margin (of a sole, at each edge)"
_WALK = """# {name} walks: linefoot walk --robot {folder}
# To edit: segments, and whatever else a scenario may have; the rest has the robot's size already.
"""


def first_speed(com_height: float) -> float:
    """Return how fast a robot walks first [m/s], by the height of its CoM [m]."""
    return SPEED * math.sqrt(com_height / SPEED_HEIGHT)


def check_new(folder: Path) -> None:
    """Raise OutputError when there is something of a folder's name."""
    if folder.exists() or folder.is_symlink():
        raise OutputError(folder, "exists already: name another with --out")


def write_folder(folder: Path, found: Finding) -> None:
    """Write description and scenario: both, or on an error nothing.

    Raises:
        OutputError: the folder exists or cannot be written.
    """
    check_new(folder)
    name = found.data["name"]
    first = {key: found.data[key] for key in ("name", *_FIRST) if key in found.data}
    margin = _MARGIN if "contact_margin" in first else ""
    description = _HEAD.format(name=name, margin=margin) + _text(first | found.data)
    walk = _WALK.format(name=name, folder=folder) + _text(walk_scenario(found))
    with writing(folder):
        folder.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".linefoot-", dir=folder.parent) as scratch:
            new = Path(scratch) / "new"
            new.mkdir()
            (new / f"{name}.yaml").write_text(description, encoding="utf-8")
            (new / SCENARIO).write_text(walk, encoding="utf-8")
            os.rename(new, folder)


def scenario_beside(description: Path) -> str | None:
    """Return the scenario in the folder of a description, if there is one."""
    file = description.parent / SCENARIO
    return str(file) if file.is_file() else None


def walk_scenario(found: Finding) -> dict[str, Any]:
    """Return a scenario of 10 s that walks a robot: stand, ahead, stop."""
    gait = scaled(GaitParameters(), found.humanoid)
    speed = first_speed(gait.com_height)
    size = units_of(found.humanoid)
    points = found.humanoid.contact_points.shape[1]
    stiffness = STIFFNESS * size["N"] / size["m"] * LINE_POINTS / points
    velocity = [round(speed, 2), 0.0]
    return {
        "name": f"{found.data['name']} walks",
        "robot": f"{found.data['name']}.yaml",  # beside it
        "segments": [
            {"name": "stand", "duration": 1.0},
            {"name": "forward", "duration": 7.0, "walk": True, "velocity": velocity},
            {"name": "stop", "duration": 2.0},  # longer than a tall robot takes to come to rest
        ],
        "ground": {"point_contact_stiffness": float(f"{stiffness:.3g}")},
    }


def _text(data: dict[str, Any]) -> str:
    return yaml.safe_dump(data, sort_keys=False, allow_unicode=True, width=100)
