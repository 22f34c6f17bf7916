"""The numbers of a URDF: as many as there should be, finite, and such as a robot can have."""

import math
import xml.etree.ElementTree as ET
from pathlib import Path

from drake_linefoot.checks import shown
from drake_linefoot.errors import ModelError

_LENGTH, _MOST = (0.0, 100.0), 1e6  # [m]; of whatever has no other bound
_WIDE = (-_MOST, _MOST)
# By element, without its namespace: how many numbers an attribute has, and their bounds.
_BOUNDS: dict[str, tuple[int, tuple[float, float]]] = {
    "mass": (1, (0.0, 1e5)),  # [kg]
    "inertia": (1, _WIDE),  # [kg m^2]; Drake mends what no body can have, and says so
    "origin": (3, (-1e3, 1e3)),  # [m, rad]
    "axis": (3, _WIDE),
    "sphere": (1, _LENGTH),
    "cylinder": (1, _LENGTH),
    "capsule": (1, _LENGTH),
    "box": (3, _LENGTH),
    "limit": (1, (-math.inf, math.inf)),
    "dynamics": (1, (0.0, _MOST)),  # [N m s/rad, N m]
    "rotor_inertia": (1, (0.0, 1e3)),  # [kg m^2]
    "gear_ratio": (1, (1e-6, _MOST)),
    "mu_static": (1, (0.0, 1e3)),
    "mu_dynamic": (1, (0.0, 1e3)),
    "point_contact_stiffness": (1, (1.0, 1e12)),  # [N/m]
    "hunt_crossley_dissipation": (1, (0.0, _MOST)),  # [s/m]
}
_TEXTS = ("name", "type")


def check_numbers(root: ET.Element, path: Path, file: Path) -> None:
    """Check that numbers are numbers within their bounds, and that limits are in order.

    Raises:
        ModelError: one is not; it names link or joint, model and description.
    """

    def refuse(owner: ET.Element, problem: str) -> ModelError:
        found = f"{shown(owner.get('name') or owner.get('type'))}: {problem}"
        return ModelError(file, "model", str(path), found)

    for owner in (e for tag in ("link", "joint", "transmission") for e in root.iter(tag)):
        for element in owner.iter():
            tag = str(element.tag).rpartition("}")[2]
            for key, value in element.attrib.items() if tag in _BOUNDS else ():
                if key not in _TEXTS and (problem := _misfit(value, *_BOUNDS[tag])):
                    raise refuse(owner, f"{tag} {key} is {shown(value)!r}, {problem}")
        limit = owner.find("limit") if owner.tag == "joint" else None
        if limit is None or owner.get("type") == "continuous":
            continue
        lower, upper = (float(limit.get(key, "0")) for key in ("lower", "upper"))
        if lower > upper:
            raise refuse(owner, f"limits are reversed, {lower:g} to {upper:g}")


def _misfit(text: str, count: int, bounds: tuple[float, float]) -> str:
    """Return what is wrong with the numbers of an attribute; nothing when they are fine.

    Drake says it when there are not three of three.
    """
    low, high = bounds
    words = text.split()
    try:
        values = [float(word) for word in words]
    except ValueError:
        values = [math.nan]
    if (count == 1 != len(words)) or not all(math.isfinite(v) or abs(v) <= high for v in values):
        return f"which must be {'a finite number' if count == 1 else 'finite numbers'}"
    if all(low <= value <= high for value in values):
        return ""
    if min(values) >= low:
        return f"which must be at most {high:g}"
    return f"which must be at least {low:g}" if low else "which must not be negative"
