"""What of a model's XML is refused, left out or named otherwise, so that Drake takes it.

Numbers must be as many as there should be, finite, and such as a robot can have.
"""

import math
import os
import sys
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import unquote, urlparse

from drake_linefoot.checks import shown
from drake_linefoot.errors import ModelError
from drake_linefoot.robot.meshes import as_obj, drawable

LFS = b"version https://git-lfs"  # how a file begins that git-lfs has not fetched
MOVING = ("revolute", "continuous", "prismatic")
_SIMPLE = ("SimpleTransmission", "transmission_interface/SimpleTransmission")
_LENGTH, _MOST = (0.0, 100.0), 1e6  # [m]; of whatever has no other bound
_WIDE = (-_MOST, _MOST)
# By element, without its namespace: how many numbers an attribute has, and their bounds.
_BOUNDS: dict[str, tuple[int, tuple[float, float]]] = {
    "mass": (1, (0.0, 1e5)),  # [kg]
    "inertia": (1, _WIDE),  # [kg m^2]; what no body can have: see model_inertia
    "origin": (3, (-1e3, 1e3)),  # [m, rad]
    "axis": (3, _WIDE),
    "sphere": (1, _LENGTH),
    "cylinder": (1, _LENGTH),
    "capsule": (1, _LENGTH),
    "box": (3, _LENGTH),
    "limit": (1, (-sys.float_info.max, sys.float_info.max)),
    "dynamics": (1, (0.0, _MOST)),  # [N m s/rad, N m]
    "rotor_inertia": (1, (0.0, 1e3)),  # [kg m^2]
    "gear_ratio": (1, (1e-6, _MOST)),
    "mu_static": (1, (0.0, 1e3)),
    "mu_dynamic": (1, (0.0, 1e3)),
    "point_contact_stiffness": (1, (1.0, 1e12)),  # [N/m]
    "hunt_crossley_dissipation": (1, (0.0, _MOST)),  # [s/m]
}
_SDF_BOUNDS = {"mass": _BOUNDS["mass"]} | dict.fromkeys(
    ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), _BOUNDS["inertia"]
)
_SOME_MASS = (1e-9, 1e5)  # [kg] of MJCF, which has no body without one
_TEXTS = ("name", "type")
_GREY, _LIGHTS = "0.7 0.7 0.7 1", ("ambient", "diffuse", "specular", "emissive")


def repair_meshes(root: ET.Element, path: Path, file: Path, notes: Counter[str]) -> None:
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
            _check_fetched(place, path, file)
            if uri is None:
                mesh.set("filename", place.as_uri())
            else:
                uri.text = place.as_uri()


def _check_fetched(mesh: Path, path: Path, file: Path) -> None:
    """Raise ModelError when a mesh is a pointer of git-lfs."""
    with mesh.open("rb") as stream:
        if stream.read(len(LFS)).startswith(LFS):
            found = f"{mesh.name} is a pointer of git-lfs: run git lfs pull"
            raise ModelError(file, "model", str(path), found)


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


def repair_assets(root: ET.Element, path: Path, file: Path, notes: Counter[str]) -> None:
    """Name an OBJ file for each mesh of MJCF, the one kind that Drake takes there.

    What is made of meshes that are not there, or cannot be read, is left out.
    """
    folder = "".join(c.attrib.pop("meshdir", "") for c in root.findall("compiler"))
    lost = set()
    for assets in root.findall("asset"):
        for mesh in assets.findall("mesh"):
            named = mesh.get("file", "")
            place = find_mesh(os.path.join(folder, named), path)
            mesh.set("name", mesh.get("name") or Path(named).stem)
            if place is not None:
                _check_fetched(place, path, file)
            try:
                mesh.set("file", str(as_obj(place)) if place else "")
            except ValueError:
                place = None
                notes["meshes: cannot be read, left out"] += 1
            if place is None:
                assets.remove(mesh)
                lost.add(mesh.get("name"))
    for body in root.iter("body"):
        for geom in body.findall("geom"):
            if geom.get("mesh") in lost:
                body.remove(geom)
                notes["drawings and shapes: of meshes that are lost, left out"] += 1


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


def repair_root(root: ET.Element, notes: Counter[str]) -> None:
    """Leave out a link without mass that carries the robot by a floating joint, as `world` does."""
    links = {link.get("name"): link for link in root.findall("link")}
    for joint in root.findall("joint"):
        parent, child = (getattr(joint.find(end), "attrib", {}) for end in ("parent", "child"))
        name = parent.get("link")
        others = [j for j in root.findall("joint") if j is not joint]
        ends = [e.get("link") for j in others for e in (*j.findall("parent"), *j.findall("child"))]
        carries = joint.get("type") == "floating" and name in links and name != "world"
        if carries and name not in ends and links[name].find("inertial") is None and child:
            root.remove(links[name])
            root.remove(joint)
            notes[f"link without mass that carries the robot left out: {name}"] += 1


def _is_colour(text: str) -> bool:
    try:
        values = [float(word) for word in text.split()]
    except ValueError:
        return False
    return len(values) in (3, 4) and all(0.0 <= value <= 1.0 for value in values)


def repair_colours(root: ET.Element, notes: Counter[str]) -> None:
    """Leave out colours of drawings with values that are not from 0 to 1."""
    wrong = [e for e in root.iter() if "rgba" in e.attrib and not _is_colour(e.get("rgba", ""))]
    for element in wrong:
        if element.tag == "color":  # URDF needs one
            element.set("rgba", _GREY)
        else:
            del element.attrib["rgba"]
    lights = [(m, part) for m in root.iter("material") for part in m if part.tag in _LIGHTS]  # SDF
    dark = [(m, part) for m, part in lights if not _is_colour(part.text or "")]
    for material, part in dark:
        material.remove(part)
    if wrong or dark:
        notes["drawings: colour not from 0 to 1, left out"] += len(wrong) + len(dark)


def repair_textures(root: ET.Element, notes: Counter[str]) -> None:
    """Leave out textures of MJCF, and its materials that are nowhere defined."""
    if root.tag != "mujoco":
        return
    for assets in root.findall("asset"):
        for texture in assets.findall("texture"):
            assets.remove(texture)
    known = {material.get("name") for material in root.iter("material")}
    for element in root.iter():
        if element.tag == "material":
            element.attrib.pop("texture", None)
        elif element.get("material") and element.get("material") not in known:
            del element.attrib["material"]
            notes["drawings: unknown material left out"] += 1


def repair_materials(root: ET.Element, notes: Counter[str]) -> None:
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


def repair_transmissions(root: ET.Element, notes: Counter[str]) -> None:
    """Leave out transmissions that Drake makes no actuator of."""
    moving = {j.get("name") for j in root.findall("joint") if j.get("type") in MOVING}
    for transmission in root.findall("transmission"):
        joints, actuators = transmission.findall("joint"), transmission.findall("actuator")
        kind = (transmission.findtext("type") or transmission.get("type") or "").strip()
        fits = len(joints) == len(actuators) == 1 and joints[0].get("name") in moving
        if not (fits and kind in _SIMPLE and actuators[0].get("name")):
            root.remove(transmission)
            notes["transmissions: not of the simple kind, left out"] += 1


def check_numbers(root: ET.Element, path: Path, file: Path) -> None:
    """Check that numbers are numbers within their bounds, and that limits are in order.

    Raises:
        ModelError: one is not; it names link or joint, model and description.
    """

    def refuse(owner: ET.Element, problem: str) -> ModelError:
        found = f"{shown(owner.get('name') or owner.get('type'))}: {problem}"
        return ModelError(file, "model", str(path), found)

    for owner in (e for tag in ("link", "joint", "transmission", "body") for e in root.iter(tag)):
        for problem in _problems(owner):
            raise refuse(owner, problem)
    masses = root.findall("link/inertial/mass")
    if root.tag == "robot" and not any(float(mass.get("value", "0")) > 0.0 for mass in masses):
        raise refuse(root, "no link has a mass: each that moves needs an <inertial>")


def _problems(owner: ET.Element) -> Iterator[str]:
    """Yield what is wrong with the numbers of a link or a joint, of MJCF's body, or below it."""
    for mass in (each.get("mass", "1") for each in owner.findall("inertial")):
        if problem := _misfit(mass, 1, _SOME_MASS):
            yield f"mass is {shown(mass)!r}, {problem}"
    if owner.tag == "body":
        return
    for element in owner.iter():
        tag = str(element.tag).rpartition("}")[2]
        text = (element.text or "").strip() if tag in _SDF_BOUNDS else ""
        if text and (problem := _misfit(text, *_SDF_BOUNDS[tag])):
            yield f"{tag} is {shown(text)!r}, {problem}"
        for key, value in element.attrib.items() if tag in _BOUNDS else ():
            if owner.get("type") == "continuous" and key in ("lower", "upper"):
                continue  # it has none
            if key not in _TEXTS and (problem := _misfit(value, *_BOUNDS[tag])):
                yield f"{tag} {key} is {shown(value)!r}, {problem}"
    limit = owner.find("limit") if owner.tag == "joint" else None
    if limit is not None and owner.get("type") != "continuous":
        lower, upper = (float(limit.get(key, "0")) for key in ("lower", "upper"))
        if lower > upper:
            yield f"limits are reversed, {lower:g} to {upper:g}"


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
