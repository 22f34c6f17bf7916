"""Robots made of the MIT Humanoid's URDF: those of the zoo, and changes that only tests make."""

import xml.etree.ElementTree as ET

import numpy as np
from scipy.spatial.transform import Rotation

from studies.common.models import named, read
from studies.zoo.made_up import (
    SIDES,
    add_joint,
    add_link,
    add_waist,
    drop_arms,
    joints_of_legs,
    mit,
    numbers,
    parts_of_link,
    put,
    put_soles,
    scale_legs,
    shuffle,
    turn_feet,
    turn_frame,
    turn_knees,
    write,
)

__all__ = [
    "SIDES",
    "add_joint",
    "add_link",
    "add_waist",
    "drop_arms",
    "joints_of_legs",
    "mit",
    "named",
    "numbers",
    "put",
    "put_soles",
    "read",
    "scale_legs",
    "shuffle",
    "turn_feet",
    "turn_frame",
    "turn_knees",
    "write",
]

TURNED = Rotation.from_euler("z", np.pi / 2)
BOX = (0.2, 0.06, 0.02)  # length, width, height of a foot [m]
BOX_AT = (0.03, 0.0, -0.05)  # its centre in the foot


def add_roll(tree):
    """Give each ankle a roll joint, as other humanoids have."""
    for side in SIDES:
        ankle = named(tree, "joint", f"{side}_ankle")
        ankle.find("child").set("link", f"{side}_ankle_link")
        add_link(tree, f"{side}_ankle_link", 0.05)
        add_joint(tree, f"{side}_ankle_roll", f"{side}_ankle_link", f"{side}_foot_link", "1 0 0")


def bound(tree, kind, lower, upper, sides=SIDES):
    """Give the joints of a kind, as "ankle", other limits of position [rad]."""
    for side in sides:
        limit = named(tree, "joint", f"{side}_{kind}").find("limit")
        limit.attrib.update(lower=str(lower), upper=str(upper))


def move_root(tree, x, y, z):
    """Put the frame of the torso elsewhere in it [m]; nothing moves."""
    inner = parts_of_link(named(tree, "link", "torso"))
    below = [j for j in tree.getroot().findall("joint") if j.find("parent").get("link") == "torso"]
    for part in [*inner, *below]:
        origin = part.find("origin")
        put(origin, "xyz", numbers(origin, "xyz") - [x, y, z])


def legs_under_waist(tree):
    """Put the legs to a pelvis that turns under the torso, which stays the root, with its arms."""
    add_link(tree, "pelvis", 1.0)
    add_joint(tree, "waist_yaw", "torso", "pelvis", "0 0 1")
    for leg in joints_of_legs(tree):
        if leg.find("parent").get("link") == "torso":
            leg.find("parent").set("link", "pelvis")


def add_table(tree):
    """Fix a heavy table to the world."""
    add_link(tree, "table", 20.0)
    tree.getroot().append(ET.Element("link", name="world"))
    joint = ET.fromstring(
        """<joint name="floor" type="fixed"><parent link="world"/><child link="table"/>
        <origin xyz="2 0.5 0.3" rpy="0 0 0"/></joint>"""
    )
    tree.getroot().append(joint)


def add_element(parent, tag, **attributes):
    parent.append(ET.Element(tag, attributes))


def drop_transmissions(tree):
    for transmission in tree.getroot().findall("transmission"):
        tree.getroot().remove(transmission)


def lose_meshes(tree):
    for mesh in tree.iter("mesh"):
        mesh.set("filename", "package://nowhere/" + mesh.get("filename").rsplit("/", 1)[1])


def box_feet(tree):
    """Feet that are boxes."""
    for side in SIDES:
        foot = named(tree, "link", f"{side}_foot_link")
        for collision in foot.findall("collision"):
            foot.remove(collision)
        size, at = (" ".join(map(str, values)) for values in (BOX, BOX_AT))
        text = f"""<collision><origin xyz="{at}" rpy="0 0 0"/>
        <geometry><box size="{size}"/></geometry></collision>"""
        foot.append(ET.fromstring(text))


def ball(at, radius):
    """A collision shape that is a ball [m]."""
    return ET.fromstring(
        f"""<collision><origin xyz="{" ".join(map(str, at))}" rpy="0 0 0"/>
        <geometry><sphere radius="{radius}"/></geometry></collision>"""
    )


def rename(tree):
    """Call every link and joint by a letter and a number; return old name -> new name."""
    new = {}
    for tag, letter in (("link", "b"), ("joint", "q")):
        for i, element in enumerate(tree.getroot().findall(tag)):
            new[element.get("name")] = f"{letter}{i}"
    for element in tree.iter():
        for key in ("name", "link", "joint"):
            if element.tag in ("link", "joint", "parent", "child") and element.get(key) in new:
                element.set(key, new[element.get(key)])
    return new
