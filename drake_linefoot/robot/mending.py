"""What is left out of a model's XML or named otherwise, so that Drake takes it."""

import os
import xml.etree.ElementTree as ET
from collections import Counter
from pathlib import Path
from urllib.parse import unquote, urlparse

from drake_linefoot.errors import ModelError
from drake_linefoot.robot.meshes import drawable

LFS = b"version https://git-lfs"  # how a file begins that git-lfs has not fetched
MOVING = ("revolute", "continuous", "prismatic")
_SIMPLE = ("SimpleTransmission", "transmission_interface/SimpleTransmission")


def mend_meshes(root: ET.Element, path: Path, file: Path, notes: Counter[str]) -> None:
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


def make_drawable(visual: ET.Element) -> bool:
    """Let a drawing name a mesh that Meshcat shows; return whether there is one."""
    for mesh in visual.findall("geometry/mesh"):
        uri = mesh.find("uri")
        name = mesh.get("filename", "") if uri is None else (uri.text or "")
        try:
            place = drawable(Path(unquote(urlparse(name).path))).as_uri()
        except ValueError:
            return False
        if uri is None:
            mesh.set("filename", place)
        else:
            uri.text = place
    return True


def mend_assets(root: ET.Element, path: Path, notes: Counter[str]) -> None:
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

    Its name is a path relative to the model's file, or package://, model:// or file://. A package
    is looked for among the folders above the model, and in those of ROS_PACKAGE_PATH.
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
    return next((place for place in candidates if name and _is_file(place)), None)


def _is_file(place: Path) -> bool:
    try:
        return place.is_file()
    except OSError:  # a name too long
        return False


def mend_materials(root: ET.Element, notes: Counter[str]) -> None:
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


def mend_transmissions(root: ET.Element, notes: Counter[str]) -> None:
    """Leave out transmissions that Drake makes no actuator of."""
    moving = {j.get("name") for j in root.findall("joint") if j.get("type") in MOVING}
    for transmission in root.findall("transmission"):
        joints, actuators = transmission.findall("joint"), transmission.findall("actuator")
        kind = (transmission.findtext("type") or transmission.get("type") or "").strip()
        fits = len(joints) == len(actuators) == 1 and joints[0].get("name") in moving
        if not (fits and kind in _SIMPLE and actuators[0].get("name")):
            root.remove(transmission)
            notes["transmissions: not of the simple kind, left out"] += 1
