"""Inertias of a model's XML that no body can have, said by link instead of by Drake's source."""

import re
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path

import numpy as np

from drake_linefoot.checks import shown
from drake_linefoot.errors import ModelError
from drake_linefoot.types import Array

_NO_BODYS = "its inertia is that of no body"
_DRAKES = re.compile(r"inertia matrix|invalid inertia")  # in what Drake says of them
_SIDES = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
_SLACK = 16.0 * np.finfo(float).eps  # [-] of the largest moment there may be; Drake's


def check_inertias(root: ET.Element, path: Path, file: Path) -> Iterator[str]:
    """Yield a line for each link whose inertia Drake replaces; numbers are checked before.

    Raises:
        ModelError: MJCF has one, which Drake refuses; it names body, model and description.
    """
    for owner, numbers in _inertias(root):
        moments = _moments(numbers)
        if (wrong := _wrong(moments)) and owner.tag == "body":
            raise ModelError(file, "model", str(path), f"{shown(owner.get('name'))}: {wrong}")
        if wrong:
            name = shown(owner.get("name"))
            yield f"{name}: {wrong}; taken as that of a ball of water of its mass"


def without_drakes(notes: Iterable[str], lines: Iterable[str]) -> list[str]:
    """Return what Drake says, but for the inertias that a line of a model is about."""
    known = any(_NO_BODYS in line for line in lines)
    return [note for note in dict.fromkeys(notes) if not (known and _DRAKES.search(note))]


def _inertias(root: ET.Element) -> Iterator[tuple[ET.Element, list[str]]]:
    """Yield each link or body that says its inertia, and the six numbers."""
    for link in root.iter("link"):
        for inertia in link.findall("inertial/inertia"):
            yield link, [inertia.get(side) or inertia.findtext(side) or "0" for side in _SIDES]
    for body in root.iter("body"):
        for inertial in body.findall("inertial"):
            words = (inertial.get("fullinertia") or inertial.get("diaginertia") or "").split()
            if len(words) in (3, 6):
                yield body, [*words, "0", "0", "0"][:6]


def _moments(numbers: Iterable[str]) -> Array:
    """Return the principal moments from the smallest on; zeros when they are no numbers."""
    with suppress(ValueError):
        xx, yy, zz, xy, xz, yz = map(float, numbers)
        matrix = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        if np.isfinite(matrix).all():
            return np.linalg.eigvalsh(matrix)
    return np.zeros(3)


def _wrong(moments: Array) -> str:
    """Return why no body has such principal moments; nothing when one can."""
    slack, said = _SLACK * abs(moments.sum()), ", ".join(f"{moment:.4g}" for moment in moments)
    if moments[0] < -slack:
        return f"{_NO_BODYS}: a moment of {said} kg m^2 is below zero"
    if moments[0] + moments[1] < moments[2] - slack:
        return f"{_NO_BODYS}: the largest of {said} kg m^2 exceeds the sum of the others"
    return ""
