"""The file of a model as other projects write it, made into what Drake takes.

What Drake would refuse and a walk does without is taken out of URDF, SDF and MJCF: drawings and
shapes of meshes that are not there, friction of joints, unknown materials, transmissions of other
kinds. Each kind leaves one line that says so. Other formats are read by Drake as they are.
"""

import math
import re
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Container
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from drake_linefoot.errors import ModelError
from drake_linefoot.files import read_file
from drake_linefoot.robot.model_inertia import check_inertias
from drake_linefoot.robot.model_repair import (
    LFS,
    MOVING,
    check_numbers,
    make_drawable,
    repair_assets,
    repair_colours,
    repair_materials,
    repair_meshes,
    repair_root,
    repair_textures,
    repair_transmissions,
)

DRAWN = "collision_shape_"  # begins the name of a collision shape that is made a drawing
LARGEST = 2**25  # bytes
DEEPEST = 200  # elements inside each other
MOST_ATTRIBUTES, MOST_PARTS = 100, 2000  # of an element; links, joints
MOST_NAMESPACES = 8  # that are looked at
SPEED = 20.0  # [rad/s] limit of joints whose format has none


@dataclass(frozen=True)
class ModelFile:
    """A model that has been read.

    Attributes:
        path: the file.
        root: its XML, mended; None for formats that are left to Drake.
        efforts: joint -> effort limit that the file gives, URDF only [N m].
        mimics: joints that follow others in the file, which is left out.
        notes: what was changed, a line each.
    """

    path: Path
    root: ET.Element | None
    efforts: dict[str, float]
    mimics: tuple[str, ...]
    notes: tuple[str, ...]

    def text(self, keep: Container[str], drawn: bool) -> str | None:
        """Return the XML for Drake's parser, with the collision shapes of the links `keep` only.

        Each mesh of a drawing is one that Meshcat shows; without `drawn` there are no drawings.
        """
        if self.root is None:
            return None
        root = ET.fromstring(ET.tostring(self.root))
        for link in root.iter("link"):
            for collision in link.findall("collision") if link.get("name") not in keep else []:
                link.remove(collision)
            for visual in link.findall("visual"):
                if not (drawn and make_drawable(visual)):
                    link.remove(visual)
        for geom in root.iter("geom"):  # of MJCF
            geom.attrib.update(contype="0", conaffinity="0")
        return ET.tostring(root, encoding="unicode")

    def drawn_shapes(self) -> str | None:
        """Return the XML with what feet are made of as drawings, which Drake takes of any kind.

        A link with collision shapes has these instead of its own drawings.
        """
        if self.root is None:
            return None
        root = ET.fromstring(ET.tostring(self.root))
        for link in root.iter("link"):
            if shapes := link.findall("collision"):
                for visual in link.findall("visual"):
                    link.remove(visual)
            for i, shape in enumerate(shapes):
                shape.tag = "visual"
                shape.set("name", f"{DRAWN}{i}")
        return ET.tostring(root, encoding="unicode")

    @property
    def knows_no_speeds(self) -> bool:
        """Whether the format has no limits of speed, as MJCF."""
        return self.root is not None and self.root.tag == "mujoco"

    @property
    def may_turn_without_end(self) -> bool:
        """Whether a joint without limits of position turns without end, as in SDF and MJCF."""
        return self.root is None or self.root.tag != "robot"

    @property
    def shapes(self) -> int:
        """Number of collision shapes, or of MJCF's geoms, which are drawings as well."""
        found = [] if self.root is None else self.root.findall(".//link/collision")
        return len(found) or (0 if self.root is None else len(self.root.findall(".//geom")))

    @property
    def line_feet(self) -> set[str]:
        """Names of the links with two collision shapes, which are spheres."""
        links = [] if self.root is None else self.root.iter("link")
        return {
            link.get("name", "")
            for link in links
            if len(link.findall("collision")) == 2
            and len(link.findall("collision/geometry/sphere")) == 2
        }


def read_model_file(path: Path, file: Path) -> ModelFile:
    """Read a model and mend it; errors name `file`, the description that it is of.

    Raises:
        ModelError: it cannot be read, is a pointer of git-lfs or no XML, or `check_numbers` refuses
            it.
    """
    root = _read_xml(path, file)
    if root is None:
        return ModelFile(path, None, {}, (), ())
    check_numbers(root, path, file)
    notes: Counter[str] = Counter()
    repair_meshes(root, path, file, notes)
    repair_assets(root, path, file, notes)
    repair_root(root, notes)
    repair_colours(root, notes)
    repair_textures(root, notes)
    repair_materials(root, notes)
    efforts, mimics = {}, []
    for joint in root.findall("joint"):
        name, limit = joint.get("name", ""), joint.find("limit")
        if joint.get("type") == "continuous" and limit is not None:
            joint.set("type", "revolute")
            limit.attrib.update(lower=str(-math.pi), upper=str(math.pi))
            notes["joints: continuous, bounded by half a turn either way"] += 1
        if limit is not None and limit.get("effort"):
            efforts[name] = float(limit.get("effort", ""))
        for dynamics in joint.findall("dynamics"):
            if float(dynamics.attrib.pop("friction", 0.0)):
                notes["joints: friction left out (error.joint_friction of a scenario has it)"] += 1
        for mimic in joint.findall("mimic"):
            if joint.get("type") in MOVING:
                mimics.append(name)
            joint.remove(mimic)
    repair_transmissions(root, notes)
    lines = [f"{count} {what}" for what, count in notes.items()]
    lines += check_inertias(root, path, file)
    if root.tag == "mujoco":
        lines.append(f"MJCF has no limits of speed: {SPEED:g} rad/s taken")
    return ModelFile(path, root, efforts, tuple(mimics), tuple(lines))


def _read_xml(path: Path, file: Path) -> ET.Element | None:
    """Return the XML of a file; None for formats that are left to Drake."""
    try:
        content = read_file(path, LARGEST)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise ModelError(file, "model", str(path), f"cannot be read: {reason}") from error
    if content.startswith(LFS):
        allowed = "is a pointer of git-lfs, not the file itself: run git lfs pull"
        raise ModelError(file, "model", str(path), allowed)
    if path.suffix.lower() not in (".urdf", ".sdf", ".xml"):
        return None
    try:
        text = content.decode("utf-8")
        if "<!ENTITY" in text:  # a few of them can stand for gigabytes
            raise ValueError("it declares entities, which are not read")
        named = re.finditer(r'xmlns:(\w+)\s*=\s*["\']([^"\']+)["\']', text)
        for prefix, uri in (each.groups() for each in islice(named, MOST_NAMESPACES)):
            if prefix == "drake" or "drake.mit.edu" in uri:
                ET.register_namespace("drake", uri)  # Drake knows it by this prefix
        root = ET.fromstring(text)
        _check_size(root)
        return root
    except UnicodeDecodeError as error:
        raise ModelError(file, "model", str(path), "is not UTF-8 text") from error
    except (ET.ParseError, ValueError) as error:
        raise ModelError(file, "model", str(path), f"is no XML: {error}") from error


def _check_size(root: ET.Element) -> None:
    """Raise ValueError when elements are nested too deeply to be written, or too many."""
    level = [root]
    for _ in range(DEEPEST):
        level = [child for element in level for child in element]
    if level:
        raise ValueError("it is nested too deeply")
    if (most := max(len(element.attrib) for element in root.iter())) > MOST_ATTRIBUTES:
        raise ValueError(f"an element has {most} attributes")  # Drake's time is their square
    for tag in ("link", "joint", "body", "geom"):
        if (count := sum(1 for _ in root.iter(tag))) > MOST_PARTS:
            raise ValueError(f"it has {count} elements called {tag}")
