"""Where the models and the shipped scenarios are, in a checkout and in a wheel.

In a wheel both folders lie inside the package; in a checkout (also an editable install)
they lie beside it. A folder counts only when it holds what it should: a folder of the
same name, put beside the package by somebody else, is not ours.
"""

from __future__ import annotations

from pathlib import Path

from drake_linefoot.errors import LinefootError

PACKAGE = Path(__file__).resolve().parent


def models_dir() -> Path:
    """Return the folder of the robot, ground and scene descriptions.

    Raises:
        LinefootError: there is none, neither inside the package nor beside it.
    """
    return _find("models", holding="package.xml")


def diagrams_dir() -> Path:
    """Return the folder of the shipped scenarios, one `NAME.yaml` per diagram.

    Raises:
        LinefootError: there is none, neither inside the package nor beside it.
    """
    return _find("diagrams", holding="*.yaml")


def package_xml() -> Path:
    """Return the file that gives `models_dir` its `package://` name.

    It is what `pydrake.multibody.parsing.PackageMap.AddPackageXml` takes.

    Raises:
        LinefootError: there is no folder of models.
    """
    return models_dir() / "package.xml"


def _find(name: str, holding: str) -> Path:
    """Return the folder `name` with a file that matches `holding`, the package's first."""
    places = (PACKAGE / name, PACKAGE.parent / name)
    for place in places:
        if any(place.glob(holding)):
            return place
    inside, beside = places
    raise LinefootError(
        f"no folder {name!r} holding {holding}: neither in the package ({inside}) "
        f"nor beside it ({beside}); is the installation complete?"
    )
