"""Robots made of the MIT Humanoid's URDF: other legs, frames, names, shapes, joints."""

import re
import xml.etree.ElementTree as ET

import numpy as np
from scipy.spatial.transform import Rotation

from drake_linefoot.resources import models_dir

SOURCE = models_dir() / "mit_humanoid" / "mit_humanoid.urdf"
SIDES = ("left", "right")
Y_UP = Rotation.from_matrix([[1, 0, 0], [0, 0, -1], [0, 1, 0]])  # its y axis is the old z
TURNED = Rotation.from_euler("z", np.pi / 2)
BOX = (0.2, 0.06, 0.02)  # length, width, height of a foot [m]
BOX_AT = (0.03, 0.0, -0.05)  # its centre in the foot


def mit():
    """The URDF as a tree, its meshes by absolute paths."""
    tree = ET.parse(SOURCE)
    for mesh in tree.iter("mesh"):
        mesh.set("filename", (SOURCE.parent / mesh.get("filename")).as_uri())
    return tree


def named(tree, tag, name):
    return next(e for e in tree.getroot().findall(tag) if e.get("name") == name)


def numbers(element, key, default="0 0 0"):
    return np.array([float(word) for word in element.get(key, default).split()])


def put(element, key, values):
    element.set(key, " ".join(repr(float(value)) for value in values))


def joints_of_legs(tree):
    legs = re.compile(r"(left|right)_(hip_.*|knee|ankle)$")
    return [j for j in tree.getroot().findall("joint") if legs.match(j.get("name"))]


# --- changes, each in place ---------------------------------------------------------------------


def scale_legs(tree, share):
    """Make legs longer or shorter; their masses stay."""
    for joint in joints_of_legs(tree):
        link = named(tree, "link", joint.find("child").get("link"))
        inner = [link.find("inertial"), *link.findall("visual"), *link.findall("collision")]
        parts = inner if joint.find("parent").get("link") == "torso" else [joint, *inner]
        for part in parts:
            put(part.find("origin"), "xyz", share * numbers(part.find("origin"), "xyz"))


def turn_knees(tree):
    """Let knees bend the other way."""
    for joint in joints_of_legs(tree):
        if re.search("pitch|knee|ankle", joint.get("name")):
            limit = joint.find("limit")
            lower, upper = float(limit.get("lower")), float(limit.get("upper"))
            limit.set("lower", str(-upper))
            limit.set("upper", str(-lower))


def turn_frame(tree, link_name, turn):
    """Give a link another frame, turned by `turn` against the old one; nothing moves."""
    link, back = named(tree, "link", link_name), turn.inv()
    for part in [link.find("inertial"), *link.findall("visual"), *link.findall("collision")]:
        turn_origin(part, back)
    for joint in tree.getroot().findall("joint"):
        if joint.find("parent").get("link") == link_name:
            turn_origin(joint, back)
        elif joint.find("child").get("link") == link_name:
            old = joint.find("origin")
            R = Rotation.from_euler("xyz", numbers(old, "rpy")) * turn
            put(old, "rpy", R.as_euler("xyz"))
            put(joint.find("axis"), "xyz", back.apply(numbers(joint.find("axis"), "xyz")))


def turn_origin(part, turn):
    """Turn where a part of a link is."""
    origin = part.find("origin")
    put(origin, "xyz", turn.apply(numbers(origin, "xyz")))
    put(origin, "rpy", (turn * Rotation.from_euler("xyz", numbers(origin, "rpy"))).as_euler("xyz"))


def add_roll(tree):
    """Give each ankle a roll joint, as other humanoids have."""
    for side in SIDES:
        ankle = named(tree, "joint", f"{side}_ankle")
        ankle.find("child").set("link", f"{side}_ankle_link")
        add_link(tree, f"{side}_ankle_link", 0.05)
        add_joint(tree, f"{side}_ankle_roll", f"{side}_ankle_link", f"{side}_foot_link", "1 0 0")


def add_waist(tree):
    """Put the legs to a pelvis of their own, which turns against the torso; it is the root."""
    add_link(tree, "pelvis", 1.0, first=True)
    add_joint(tree, "waist_yaw", "pelvis", "torso", "0 0 1")
    for joint in joints_of_legs(tree):
        if joint.find("parent").get("link") == "torso":
            joint.find("parent").set("link", "pelvis")


def add_link(tree, name, mass, first=False):
    text = f"""<link name="{name}"><inertial><origin xyz="0 0 0" rpy="0 0 0"/>
    <mass value="{mass}"/><inertia ixx="{0.001 * mass}" iyy="{0.001 * mass}"
    izz="{0.001 * mass}" ixy="0" ixz="0" iyz="0"/></inertial></link>"""
    tree.getroot().insert(0 if first else len(tree.getroot()), ET.fromstring(text))


def add_joint(tree, name, parent, child, axis, kind="revolute"):
    text = f"""<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>
    <origin xyz="0 0 0" rpy="0 0 0"/><axis xyz="{axis}"/>
    <limit lower="-0.5" upper="0.5" velocity="10" effort="50"/></joint>"""
    tree.getroot().append(ET.fromstring(text))


def add_element(parent, tag, **attributes):
    parent.append(ET.Element(tag, attributes))


def drop_arms(tree):
    """Leave out the arms."""
    arm = re.compile(r"shoulder|elbow|upper_arm|forearm|_arm|hand")
    for element in list(tree.getroot()):
        if arm.search(element.get("name", "")) and element.get("name") != "torso":
            tree.getroot().remove(element)


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


def shuffle(tree):
    """Put joints and transmissions into another order in the file."""
    root = tree.getroot()
    for tag in ("joint", "transmission"):
        elements = root.findall(tag)
        for element in elements:
            root.remove(element)
        for element in elements[::-2] + elements[-2::-2]:
            root.append(element)


def write(tree, folder, name="made_up"):
    """Write a robot; return its file."""
    file = folder / f"{name}.urdf"
    tree.write(file, encoding="utf-8")
    return file
