"""Where the models and the shipped scenarios are, in a checkout and in a wheel.

In a wheel both folders lie inside the package; in a checkout (also an editable install)
they lie beside it. A folder counts only when it holds what it should: a folder of the
same name, put beside the package by somebody else, is not ours.
"""

import os
from collections.abc import Mapping
from pathlib import Path

from drake_linefoot.errors import LinefootError

PACKAGE = Path(__file__).resolve().parent


def models_dir() -> Path:
    """Return the folder of the robot, ground and scene descriptions."""
    return _find("models", holding="package.xml")


def diagrams_dir() -> Path:
    """Return the folder of the shipped scenarios, one `NAME.yaml` per diagram."""
    return _find("diagrams", holding="*.yaml")


def robot_files() -> dict[str, Path]:
    """Return the descriptions of the shipped robots by their names."""
    folders = sorted(path.parent for path in models_dir().glob("*/*.urdf"))
    return {folder.name: folder / f"{folder.name}.yaml" for folder in folders}


def scene_files() -> dict[str, Path]:
    """Return the files of the shipped scenes by their names."""
    return {path.stem: path for path in sorted(models_dir().glob("scenes/*.yaml"))}


def scenario_files() -> dict[str, Path]:
    """Return the files of the shipped scenarios by their names."""
    return {path.stem: path for path in sorted(diagrams_dir().glob("*.yaml"))}


def shipped_or_path(name: str, shipped: Mapping[str, Path]) -> Path | None:
    """Return the shipped file of a name, or the YAML file or folder that it is of, or None."""
    is_path = name.endswith((".yaml", ".yml")) or os.path.isdir(name)
    return shipped.get(name, Path(name) if is_path else None)


def _find(name: str, holding: str) -> Path:
    """Return the folder `name` with a file that matches `holding`, the package's first.

    Raises:
        LinefootError: there is none, neither inside the package nor beside it.
    """
    places = (PACKAGE / name, PACKAGE.parent / name)
    for place in places:
        if any(place.glob(holding)):
            return place
    inside, beside = places
    raise LinefootError(
        f"no folder {name!r} holding {holding}: neither in the package ({inside}) "
        f"nor beside it ({beside}); is the installation complete?"
    )
