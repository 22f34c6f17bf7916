"""Other robots for the benchmark: without arms, with more joints, and for PlaCo."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.robot.humanoid import Humanoid

Array = NDArray[np.float64]

EXTRA = 5  # joints that are added
EXTRA_MASS = 0.1  # [kg] of each added link
_EXTRA_INERTIA = "1e-4"  # [kg m^2] of each


def without_arms(humanoid: Humanoid, folder: Path) -> Humanoid:
    """Return the robot with its arms welded in their zero posture.

    Args:
        humanoid: the robot.
        folder: where the model is written; existing.
    """
    tree = _bare(humanoid)
    arms = set(humanoid.description.arm_joints)
    root = tree.getroot()
    for joint in root.findall("joint"):
        if joint.get("name") in arms:
            joint.set("type", "fixed")
            for child in [c for c in joint if c.tag not in ("parent", "child", "origin")]:
                joint.remove(child)
    for transmission in root.findall("transmission"):
        moved = transmission.find("joint")
        if moved is not None and moved.get("name") in arms:
            root.remove(transmission)
    d = humanoid.description
    joints = tuple(name for name in d.actuated_joints if name not in arms)
    return _built(humanoid, tree, folder / "without_arms.urdf", joints, ())


def with_extra_joints(humanoid: Humanoid, folder: Path) -> Humanoid:
    """Return the robot with a chain of five more joints on its torso, as a neck would be.

    Args:
        humanoid: the robot.
        folder: where the model is written; existing.
    """
    tree = _bare(humanoid)
    root, d = tree.getroot(), humanoid.description
    pattern = next(t for t in root.findall("transmission"))
    names = [f"extra_{i}" for i in range(EXTRA)]
    parent = d.floating_base
    for name, axis in zip(names, ("0 0 1", "0 1 0", "1 0 0", "0 1 0", "0 0 1"), strict=True):
        link = f"{name}_link"
        _add_link(root, link)
        _add_joint(root, name, parent, link, axis)
        transmission = ET.fromstring(ET.tostring(pattern))
        transmission.set("name", f"{name}_transmission")
        for tag in ("joint", "actuator"):
            element = transmission.find(tag)
            if element is not None:
                element.set("name", name)
        root.append(transmission)
        parent = link
    return _built(
        humanoid,
        tree,
        folder / "with_extra_joints.urdf",
        (*d.actuated_joints, *names),
        (*d.arm_joints, *names),
    )


def carried_over(state: Array, source: Humanoid, target: Humanoid) -> Array:
    """Return a state for another robot: joints of the same name keep angle and rate.

    Args:
        state: [q, v] of `source`.
        source: whose state it is.
        target: whose state is returned; joints that `source` lacks are at 0.
    """
    x = target.x_nominal.copy()
    x[:7], x[target.nq : target.nq + 6] = state[:7], state[source.nq : source.nq + 6]
    at = {name: i for i, name in enumerate(source.description.actuated_joints)}
    for i, name in enumerate(target.description.actuated_joints):
        if name in at:
            x[target.actuated_q[i]] = state[source.actuated_q[at[name]]]
            x[target.nq + target.actuated_v[i]] = state[source.nq + source.actuated_v[at[name]]]
    return x


def for_placo(humanoid: Humanoid, file: Path) -> None:
    """Write the model with a frame in the middle of each contact line, `SIDE_line`."""
    tree = _bare(humanoid)
    root = tree.getroot()
    for foot, p_FC in zip(humanoid.description.feet, humanoid.p_FC, strict=True):
        ET.SubElement(root, "link", name=f"{foot.name}_line")
        joint = ET.SubElement(root, "joint", name=f"{foot.name}_line_joint", type="fixed")
        ET.SubElement(joint, "parent", link=foot.frame)
        ET.SubElement(joint, "child", link=f"{foot.name}_line")
        ET.SubElement(joint, "origin", xyz=" ".join(map(repr, p_FC.tolist())), rpy="0 0 0")
    tree.write(file, encoding="unicode", xml_declaration=True)


def _bare(humanoid: Humanoid) -> ET.ElementTree[ET.Element]:
    """Return the model without anything to look at or to collide with."""
    ET.register_namespace("drake", "https://drake.mit.edu")  # else its tags lose their name
    tree = ET.parse(humanoid.description.model)
    for link in tree.getroot().findall("link"):
        for part in [*link.findall("visual"), *link.findall("collision")]:
            link.remove(part)
    return tree


def _add_link(root: ET.Element, name: str) -> None:
    inertial = ET.SubElement(ET.SubElement(root, "link", name=name), "inertial")
    ET.SubElement(inertial, "origin", xyz="0 0 0.03", rpy="0 0 0")
    ET.SubElement(inertial, "mass", value=repr(EXTRA_MASS))
    moments = dict.fromkeys(("ixx", "iyy", "izz"), _EXTRA_INERTIA)
    ET.SubElement(inertial, "inertia", moments | dict.fromkeys(("ixy", "ixz", "iyz"), "0"))


def _add_joint(root: ET.Element, name: str, parent: str, child: str, axis: str) -> None:
    joint = ET.SubElement(root, "joint", name=name, type="revolute")
    ET.SubElement(joint, "parent", link=parent)
    ET.SubElement(joint, "child", link=child)
    ET.SubElement(joint, "origin", xyz="0 0 0.06", rpy="0 0 0")
    ET.SubElement(joint, "axis", xyz=axis)
    ET.SubElement(joint, "limit", lower="-1", upper="1", effort="10", velocity="10")


def _built(
    humanoid: Humanoid,
    tree: ET.ElementTree[ET.Element],
    model: Path,
    joints: tuple[str, ...],
    arms: tuple[str, ...],
) -> Humanoid:
    """Write the model and load it; a joint without a partner is its own mirror image."""
    tree.write(model, encoding="unicode", xml_declaration=True)
    d = humanoid.description
    mirror = {left: pair for left, pair in d.mirror.items() if left in joints}
    paired = {*mirror, *(right for right, _ in mirror.values())}
    mirror |= {name: (name, 1.0) for name in joints if name not in paired}
    posture = {name: angle for name, angle in d.nominal_posture.items() if name in joints}
    return Humanoid(
        replace(
            d,
            name=model.stem,
            model=model,
            actuated_joints=joints,
            arm_joints=arms,
            mirror=mirror,
            nominal_posture=posture,
        )
    )
