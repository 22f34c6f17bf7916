"""Robots made of the MIT Humanoid's URDF: other legs, frames, sizes, joints.

What changes a tree changes it in place.
"""

import re
import xml.etree.ElementTree as ET
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from drake_linefoot.resources import models_dir
from studies.common.models import Tree, link_of, named, part_of, read
from studies.common.types import Array

SOURCE = models_dir() / "mit_humanoid" / "mit_humanoid.urdf"
SIDES = ("left", "right")
Y_UP = Rotation.from_matrix([[1, 0, 0], [0, 0, -1], [0, 1, 0]])  # its y axis is the old z
LEG_JOINT = re.compile(r"(left|right)_(hip_.*|knee|ankle)$")
ARM = re.compile(r"shoulder|elbow|upper_arm|forearm|_arm|hand")


def mit() -> Tree:
    """Return the URDF, its meshes by absolute paths."""
    tree = read(SOURCE)
    for mesh in tree.iter("mesh"):
        mesh.set("filename", (SOURCE.parent / str(mesh.get("filename"))).as_uri())
    return tree


def write(tree: Tree, folder: Path, name: str = "made_up") -> Path:
    """Write a robot; return its file."""
    file = folder / f"{name}.urdf"
    tree.write(file, encoding="utf-8")
    return file


def numbers(element: ET.Element, key: str, default: str = "0 0 0") -> Array:
    """Return the numbers of an attribute."""
    return np.array([float(word) for word in element.get(key, default).split()])


def put(element: ET.Element, key: str, values: Iterable[float]) -> None:
    """Write numbers into an attribute."""
    element.set(key, " ".join(repr(float(value)) for value in values))


def joints_of_legs(tree: Tree) -> list[ET.Element]:
    """Return the joints of both legs."""
    return [j for j in tree.getroot().findall("joint") if LEG_JOINT.match(str(j.get("name")))]


def parts_of_link(link: ET.Element) -> list[ET.Element]:
    """Return what has a place in a link."""
    return [part_of(link, "inertial"), *link.findall("visual"), *link.findall("collision")]


# --- changes ------------------------------------------------------------------------------------


def scale_legs(tree: Tree, share: float) -> None:
    """Make legs longer or shorter; their masses stay."""
    for joint in joints_of_legs(tree):
        inner = parts_of_link(named(tree, "link", link_of(joint, "child")))
        for part in inner if link_of(joint, "parent") == "torso" else [joint, *inner]:
            origin = part_of(part, "origin")
            put(origin, "xyz", share * numbers(origin, "xyz"))


def scale_all(tree: Tree, length: float, mass: float) -> None:
    """Make a robot of another size that moves alike.

    Args:
        tree: of the robot.
        length: of everything, by what it was [-].
        mass: of everything, likewise; efforts go with mass times length, speeds with the inverse
            root of the length, inertias with mass times length squared.
    """
    inertia = mass * length**2
    factors: dict[str, dict[str, float]] = {
        "origin": {"xyz": length},
        "mass": {"value": mass},
        "inertia": {key: inertia for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")},
        "limit": {"effort": mass * length, "velocity": length**-0.5},
        "{https://drake.mit.edu}rotor_inertia": {"value": inertia},
        "sphere": {"radius": length},
        "cylinder": {"radius": length, "length": length},
        "{https://drake.mit.edu}capsule": {"radius": length, "length": length},
        "box": {"size": length},
    }
    for element in tree.iter():
        for key, factor in factors.get(str(element.tag), {}).items():
            put(element, key, factor * numbers(element, key))
        if element.tag == "mesh":
            put(element, "scale", length * numbers(element, "scale", "1 1 1"))


def limit_ankles(tree: Tree, effort: float) -> None:
    """Give the ankles another torque limit [N m]."""
    for side in SIDES:
        part_of(named(tree, "joint", f"{side}_ankle"), "limit").set("effort", str(effort))


def turn_knees(tree: Tree) -> None:
    """Let knees bend the other way."""
    for joint in joints_of_legs(tree):
        if re.search("pitch|knee|ankle", str(joint.get("name"))):
            limit = part_of(joint, "limit")
            lower, upper = numbers(limit, "lower"), numbers(limit, "upper")
            put(limit, "lower", -upper)
            put(limit, "upper", -lower)


def turn_frame(tree: Tree, link_name: str, turn: Rotation) -> None:
    """Give a link another frame, turned by `turn` against the old one; nothing moves."""
    back = turn.inv()
    for part in parts_of_link(named(tree, "link", link_name)):
        _turn_origin(part, back)
    for joint in tree.getroot().findall("joint"):
        if link_of(joint, "parent") == link_name:
            _turn_origin(joint, back)
        elif link_of(joint, "child") == link_name:
            old, axis = part_of(joint, "origin"), part_of(joint, "axis")
            R = Rotation.from_euler("xyz", numbers(old, "rpy")) * turn
            put(old, "rpy", R.as_euler("xyz"))
            put(axis, "xyz", back.apply(numbers(axis, "xyz")))


def turn_feet(tree: Tree) -> None:
    """Let y point up in the feet."""
    for side in SIDES:
        turn_frame(tree, f"{side}_foot_link", Y_UP)


def _turn_origin(part: ET.Element, turn: Rotation) -> None:
    """Turn where a part of a link is."""
    origin = part_of(part, "origin")
    put(origin, "xyz", turn.apply(numbers(origin, "xyz")))
    put(origin, "rpy", (turn * Rotation.from_euler("xyz", numbers(origin, "rpy"))).as_euler("xyz"))


def add_waist(tree: Tree) -> None:
    """Put the legs to a pelvis of their own, which turns against the torso; it is the root."""
    add_link(tree, "pelvis", 1.0, first=True)
    add_joint(tree, "waist_yaw", "pelvis", "torso", "0 0 1")
    for joint in joints_of_legs(tree):
        if link_of(joint, "parent") == "torso":
            part_of(joint, "parent").set("link", "pelvis")


def add_link(tree: Tree, name: str, mass: float, first: bool = False) -> None:
    """Add a link without a form; the first one is the root."""
    text = f"""<link name="{name}"><inertial><origin xyz="0 0 0" rpy="0 0 0"/>
    <mass value="{mass}"/><inertia ixx="{0.001 * mass}" iyy="{0.001 * mass}"
    izz="{0.001 * mass}" ixy="0" ixz="0" iyz="0"/></inertial></link>"""
    tree.getroot().insert(0 if first else len(tree.getroot()), ET.fromstring(text))


def add_joint(
    tree: Tree, name: str, parent: str, child: str, axis: str, kind: str = "revolute"
) -> None:
    """Add a joint in the origin of its parent."""
    text = f"""<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>
    <origin xyz="0 0 0" rpy="0 0 0"/><axis xyz="{axis}"/>
    <limit lower="-0.5" upper="0.5" velocity="10" effort="50"/></joint>"""
    tree.getroot().append(ET.fromstring(text))


def drop_arms(tree: Tree) -> None:
    """Leave out the arms."""
    for element in list(tree.getroot()):
        if ARM.search(element.get("name", "")):
            tree.getroot().remove(element)


def shuffle(tree: Tree) -> None:
    """Put joints and transmissions into another order in the file."""
    root = tree.getroot()
    for tag in ("joint", "transmission"):
        elements = root.findall(tag)
        for element in elements:
            root.remove(element)
        root.extend(elements[::-2] + elements[-2::-2])


def put_soles(tree: Tree, heel: float, toe: float) -> None:
    """Put heels and toes elsewhere, ahead of the ankle [m]."""
    for side in SIDES:
        for collision in named(tree, "link", f"{side}_foot_link").findall("collision"):
            origin = part_of(collision, "origin")
            _, y, z = place = numbers(origin, "xyz")
            put(origin, "xyz", (toe if place[0] > 0.0 else heel, y, z))
