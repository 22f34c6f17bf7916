"""The file of a model as other projects write it, made into what Drake takes.

What Drake would refuse and a walk does without is taken out of URDF, SDF and MJCF: drawings and
shapes of meshes that are not there, friction of joints, unknown materials, transmissions of other
kinds. Each kind leaves one line that says so. Other formats are read by Drake as they are.
"""

import math
import os
import re
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Container
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import unquote, urlparse

from drake_linefoot.checks import shown
from drake_linefoot.errors import ModelError

LFS = b"version https://git-lfs"  # how a file begins that git-lfs has not fetched
DRAWN = "collision_shape_"  # begins the name of a collision shape that is made a drawing
SPEED = 20.0  # [rad/s] limit of joints whose format has none
_MOVING = ("revolute", "continuous", "prismatic")
_SIMPLE = ("SimpleTransmission", "transmission_interface/SimpleTransmission")
_SINGLE = {"mass", "inertia", "limit", "sphere", "cylinder", "dynamics"}  # a number each
_NUMBERS = {*_SINGLE, "origin", "axis", "box"}


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

    def text(self, keep: Container[str]) -> str | None:
        """Return the XML for Drake's parser, with the collision shapes of some links only.

        Args:
            keep: names of those links.
        """
        if self.root is None:
            return None
        root = ET.fromstring(ET.tostring(self.root))
        for link in root.iter("link"):
            for collision in link.findall("collision") if link.get("name") not in keep else []:
                link.remove(collision)
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
    """Read a model and mend it.

    Args:
        path: of the model.
        file: the description that names it, for errors.

    Raises:
        ModelError: it cannot be read, is a pointer of git-lfs or no XML, or has numbers that are
            not finite or limits that are reversed.
    """
    root = _read_xml(path, file)
    if root is None:
        return ModelFile(path, None, {}, (), ())
    _check_numbers(root, path, file)
    notes: Counter[str] = Counter()
    _mend_meshes(root, path, file, notes)
    _mend_assets(root, path, notes)
    _mend_materials(root, notes)
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
            if joint.get("type") in _MOVING:
                mimics.append(name)
            joint.remove(mimic)
    _mend_transmissions(root, notes)
    lines = [f"{count} {what}" for what, count in notes.items()]
    if root.tag == "mujoco":
        lines.append(f"MJCF has no limits of speed: {SPEED:g} rad/s taken")
    return ModelFile(path, root, efforts, tuple(mimics), tuple(lines))


def _read_xml(path: Path, file: Path) -> ET.Element | None:
    """Return the XML of a file; None for formats that are left to Drake."""
    try:
        content = path.read_bytes()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise ModelError(file, "model", str(path), f"cannot be read: {reason}") from error
    _check_fetched(content, path, file)
    if path.suffix.lower() not in (".urdf", ".sdf", ".xml"):
        return None
    try:
        text = content.decode("utf-8")
        for prefix, uri in re.findall(r'xmlns:(\w+)\s*=\s*["\']([^"\']+)["\']', text):
            if prefix == "drake" or "drake.mit.edu" in uri:
                ET.register_namespace("drake", uri)  # Drake knows it by this prefix
        return ET.fromstring(text)
    except UnicodeDecodeError as error:
        raise ModelError(file, "model", str(path), "is not UTF-8 text") from error
    except (ET.ParseError, ValueError) as error:
        raise ModelError(file, "model", str(path), f"is no XML: {error}") from error


def _check_fetched(content: bytes, path: Path, file: Path) -> None:
    if content.startswith(LFS):
        allowed = "is a pointer of git-lfs, not the file itself: run git lfs pull"
        raise ModelError(file, "model", str(path), allowed)


def _check_numbers(root: ET.Element, path: Path, file: Path) -> None:
    """Check that numbers are numbers and that limits are in order."""
    for owner in [*root.iter("link"), *root.iter("joint")]:
        for element in owner.iter():
            for key, value in element.attrib.items() if element.tag in _NUMBERS else ():
                wrong = "" if key in ("name", "type") else _misfit(element.tag, value)
                if wrong:
                    found = f"{owner.get('name')}: {element.tag} {key} is {shown(value)!r}, {wrong}"
                    raise ModelError(file, "model", str(path), found)
        limit = owner.find("limit") if owner.tag == "joint" else None
        if limit is None or owner.get("type") == "continuous":
            continue
        lower, upper = (float(limit.get(key, "0")) for key in ("lower", "upper"))
        if lower > upper:
            found = f"{owner.get('name')}: limits are reversed, {lower:g} to {upper:g}"
            raise ModelError(file, "model", str(path), found)


def _misfit(tag: str, value: str) -> str:
    """Return what is wrong with the numbers of an attribute; nothing when they are fine."""
    words, one = value.split(), tag in _SINGLE
    if (one and len(words) != 1) or not all(_is_number(w, tag == "limit") for w in words):
        return f"which must be {'a finite number' if one else 'finite numbers'}"
    return "which must not be negative" if tag == "mass" and float(value) < 0.0 else ""


def _is_number(word: str, unlimited: bool) -> bool:
    try:
        value = float(word)
    except ValueError:
        return False
    return math.isfinite(value) or (unlimited and math.isinf(value))


def _mend_meshes(root: ET.Element, path: Path, file: Path, notes: Counter[str]) -> None:
    """Name each mesh by its place; leave out those that are not there."""
    for link in root.iter("link"):
        for shape in [*link.findall("visual"), *link.findall("collision")]:
            mesh = shape.find("geometry/mesh")
            if mesh is None:
                continue
            uri = mesh.find("uri")
            name = mesh.get("filename") if uri is None else uri.text
            place = find_mesh(name or "", path)
            if place is None:
                link.remove(shape)
                notes["meshes: not found, left out"] += 1
                continue
            with place.open("rb") as stream:
                if stream.read(len(LFS)).startswith(LFS):
                    found = f"{place.name} is a pointer of git-lfs: run git lfs pull"
                    raise ModelError(file, "model", str(path), found)
            if uri is None:
                mesh.set("filename", place.as_uri())
            else:
                uri.text = place.as_uri()


def _mend_assets(root: ET.Element, path: Path, notes: Counter[str]) -> None:
    """Name each mesh of MJCF by its place; leave out what is made of those that are not there."""
    folder = "".join(c.attrib.pop("meshdir", "") for c in root.findall("compiler"))
    lost = set()
    for assets in root.findall("asset"):
        for mesh in assets.findall("mesh"):
            file = mesh.get("file", "")
            place = find_mesh(os.path.join(folder, file), path)
            if place is None:
                assets.remove(mesh)
                lost.add(mesh.get("name") or Path(file).stem)
            else:
                mesh.set("file", str(place))
                mesh.set("name", mesh.get("name") or place.stem)
    for body in root.iter("body"):
        for geom in body.findall("geom"):
            if geom.get("mesh") in lost:
                body.remove(geom)
                notes["meshes: not found, left out"] += 1


def find_mesh(name: str, model: Path) -> Path | None:
    """Return the file of a mesh, or None.

    A package is looked for among the folders above the model, and in those of ROS_PACKAGE_PATH.

    Args:
        name: a path relative to the model, or package://, model:// or file://.
        model: file of the model.
    """
    parts = urlparse(name)
    if parts.scheme in ("package", "model"):
        inside = unquote(parts.path).lstrip("/")
        above = model.resolve().parents
        places = [folder / parts.netloc for folder in above]
        places += [folder for folder in above if folder.name == parts.netloc]
        roots = os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)
        places += [Path(folder) / parts.netloc for folder in roots if folder]
        candidates = [place / inside for place in places]
    else:
        candidates = [model.resolve().parent / unquote(parts.path if parts.scheme else name)]
    return next((place for place in candidates if name and place.is_file()), None)


def _mend_materials(root: ET.Element, notes: Counter[str]) -> None:
    """Leave out materials that are nowhere defined, and textures."""
    known = {m.get("name") for m in root.findall("material")}
    known |= {m.get("name") for m in root.iter("material") if m.find("color") is not None}
    for visual in root.iter("visual"):
        for material in visual.findall("material"):
            for texture in material.findall("texture"):
                material.remove(texture)
            if material.get("name") and material.get("name") not in known:
                visual.remove(material)
                notes["drawings: unknown material left out"] += 1


def _mend_transmissions(root: ET.Element, notes: Counter[str]) -> None:
    """Leave out transmissions that Drake makes no actuator of."""
    moving = {j.get("name") for j in root.findall("joint") if j.get("type") in _MOVING}
    for transmission in root.findall("transmission"):
        joints, actuators = transmission.findall("joint"), transmission.findall("actuator")
        kind = (transmission.findtext("type") or transmission.get("type") or "").strip()
        fits = len(joints) == len(actuators) == 1 and joints[0].get("name") in moving
        if not (fits and kind in _SIMPLE and actuators[0].get("name")):
            root.remove(transmission)
            notes["transmissions: not of the simple kind, left out"] += 1
