"""Robots made from a shipped one: heavier legs, no arms, more joints, frames for PlaCo."""

import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path
from typing import TypeAlias

import yaml

from drake_linefoot.errors import InputError
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.robot.humanoid import Humanoid, load_humanoid
from studies.common.types import Array

Tree: TypeAlias = "ET.ElementTree[ET.Element]"  # of a URDF

EXTRA_AXES = ("0 0 1", "0 1 0", "1 0 0", "0 1 0", "0 0 1")  # of the joints that are added
EXTRA_MASS = 0.1  # [kg] of each added link
_EXTRA = """<robot><link name="{name}_link"><inertial><origin xyz="0 0 0.03" rpy="0 0 0"/>
<mass value="{mass}"/><inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/>
</inertial></link><joint name="{name}" type="revolute"><parent link="{parent}"/>
<child link="{name}_link"/><origin xyz="0 0 0.06" rpy="0 0 0"/><axis xyz="{axis}"/>
<limit lower="-1" upper="1" effort="10" velocity="10"/></joint></robot>"""
_LINE = """<robot><link name="{name}_line"/><joint name="{name}_line_joint" type="fixed">
<parent link="{frame}"/><child link="{name}_line"/><origin xyz="{xyz}" rpy="0 0 0"/></joint>
</robot>"""


def read(file: Path, *without: str) -> Tree:
    """Return the URDF of a robot, to be changed, without some parts of its links."""
    ET.register_namespace("drake", "https://drake.mit.edu")  # else its tags lose their name
    tree = ET.parse(file)
    for link in tree.getroot().findall("link"):
        for part in [part for kind in without for part in link.findall(kind)]:
            link.remove(part)
    return tree


def named(tree: Tree, tag: str, name: str) -> ET.Element:
    """Return the link or joint of a name."""
    return next(e for e in tree.getroot().findall(tag) if e.get("name") == name)


def link_of(joint: ET.Element, end: str) -> str:
    """Return the name of the `parent` or the `child` of a joint."""
    return str(part_of(joint, end).get("link"))


def part_of(element: ET.Element, path: str) -> ET.Element:
    """Return a part that every model has."""
    part = element.find(path)
    if part is None:
        raise InputError(element.get("name", element.tag), path, None, "is missing in the model")
    return part


def _add(tree: Tree, text: str, **values: object) -> None:
    """Add the elements of a template."""
    tree.getroot().extend(ET.fromstring(text.format(**values)))


def _loaded(
    tree: Tree, humanoid: Humanoid, file: Path, joints: tuple[str, ...], arms: tuple[str, ...]
) -> Humanoid:
    """Write a robot and load it with other joints that have motors, and other arms."""
    tree.write(file, encoding="utf-8")
    d = humanoid.description
    posture = {name: angle for name, angle in d.nominal_posture.items() if name in joints}
    changed = replace(d, name=file.stem, model=file, actuated_joints=joints, arm_joints=arms)
    return Humanoid(replace(changed, mirror={}, nominal_posture=posture))


def leg_mass_variant(robot: str | Path, factor: float, folder: Path) -> Path:
    """Write a robot with heavier or lighter legs and the same total mass.

    Mass and inertia of every link from the hip to the foot are multiplied by `factor`; the
    torso gets (or gives) the difference, its inertia in proportion. Centres of mass, joints,
    limits and reflected inertias stay. The limits on the height of the CoM move with the CoM of
    the nominal posture.

    Args:
        robot: a shipped robot, or the path of a description.
        factor: of the legs' masses, positive.
        folder: where to; existing.

    Returns:
        The description's path.

    Raises:
        InputError: the torso has not that much to give, or the factor is not positive.
        ModelError: there is no such robot.
    """
    original = load_humanoid(robot)
    description, tree = original.description, read(original.description.model, "visual")
    joints = [name for foot in description.feet for name in foot.leg_joints]
    children = [link_of(named(tree, "joint", name), "child") for name in joints]
    legs = [named(tree, "link", name) for name in children]
    torso = named(tree, "link", description.floating_base)
    given = (1.0 - factor) * sum(_mass(link) for link in legs)
    share = 1.0 + given / _mass(torso)
    if not (factor > 0.0 and share > 0.0):
        raise InputError("leg mass", "factor", factor, "must be positive and leave the torso some")
    for link in legs:
        _scale(link, factor)
    _scale(torso, share)
    urdf = folder / f"legs_{factor:g}.urdf"
    tree.write(urdf, encoding="utf-8")
    data = yaml.safe_load(description.file.read_text(encoding="utf-8"))
    data["name"], data["model"] = f"{description.name}, legs x {factor:g}", urdf.name
    file = urdf.with_suffix(".yaml")
    file.write_text(yaml.safe_dump(data, sort_keys=False), encoding="utf-8")
    shift = com_height(load_humanoid(file)) - com_height(original)
    for name in ("com_height_min", "com_height_max"):
        data["limits"][name] += shift
    file.write_text(yaml.safe_dump(data, sort_keys=False), encoding="utf-8")
    return file


def with_robot(scenario: Scenario, robot: str | Path) -> Scenario:
    """Return a scenario with another robot of the same shape, its posture kept.

    The height of the CoM changes by as much as that of the nominal posture does, so that the
    legs bend as before.
    """
    shift = com_height(load_humanoid(robot)) - com_height(load_humanoid(scenario.robot))
    gait = replace(scenario.gait, com_height=scenario.gait.com_height + shift)
    return replace(scenario, robot=str(robot), gait=gait)


def com_height(humanoid: Humanoid) -> float:
    """Return the height of the CoM above the ground in the nominal posture [m]."""
    context = humanoid.plant.CreateDefaultContext()
    humanoid.plant.SetPositions(context, humanoid.q_nominal)
    return float(humanoid.floating.com(context)[2])


def leg_share(humanoid: Humanoid) -> float:
    """Return the legs' share of the mass [-]."""
    plant = humanoid.plant
    context = plant.CreateDefaultContext()
    names = [name for foot in humanoid.description.feet for name in foot.leg_joints]
    masses = [humanoid.names.joint(name).child_body().get_mass(context) for name in names]
    return float(sum(masses)) / humanoid.mass


def without_arms(humanoid: Humanoid, folder: Path) -> Humanoid:
    """Return the robot with its arms welded in their zero posture; the model is in `folder`."""
    d = humanoid.description
    tree = read(d.model, "visual", "collision")
    for name in d.arm_joints:
        joint = named(tree, "joint", name)
        joint.set("type", "fixed")
        for part in [p for p in joint if p.tag not in ("parent", "child", "origin")]:
            joint.remove(part)
    for transmission in tree.getroot().findall("transmission"):
        if part_of(transmission, "joint").get("name") in d.arm_joints:
            tree.getroot().remove(transmission)
    joints = tuple(name for name in d.actuated_joints if name not in d.arm_joints)
    return _loaded(tree, humanoid, folder / "without_arms.urdf", joints, ())


def with_extra_joints(humanoid: Humanoid, folder: Path) -> Humanoid:
    """Return the robot with a chain of five more joints on its torso, as a neck would be."""
    d = humanoid.description
    tree = read(d.model, "visual", "collision")
    pattern = ET.tostring(part_of(tree.getroot(), "transmission"))
    names, parent = tuple(f"extra_{i}" for i in range(len(EXTRA_AXES))), d.floating_base
    for name, axis in zip(names, EXTRA_AXES, strict=True):
        _add(tree, _EXTRA, name=name, parent=parent, axis=axis, mass=EXTRA_MASS)
        parent = f"{name}_link"
        transmission = ET.fromstring(pattern)
        transmission.set("name", f"{name}_transmission")
        for tag in ("joint", "actuator"):
            part_of(transmission, tag).set("name", name)
        tree.getroot().append(transmission)
    file = folder / "with_extra_joints.urdf"
    return _loaded(tree, humanoid, file, (*d.actuated_joints, *names), (*d.arm_joints, *names))


def for_placo(humanoid: Humanoid, file: Path) -> None:
    """Write the model with a frame in the middle of each contact line, `SIDE_line`."""
    tree = read(humanoid.description.model, "visual", "collision")
    for foot, p_FC in zip(humanoid.description.feet, humanoid.p_FC, strict=True):
        xyz = " ".join(map(repr, p_FC.tolist()))
        _add(tree, _LINE, name=foot.name, frame=foot.frame, xyz=xyz)
    tree.write(file, encoding="utf-8")


def carried_over(state: Array, source: Humanoid, target: Humanoid) -> Array:
    """Return the state [q, v] of a robot for another: joints of the same name keep angle and rate.

    Joints that `source` lacks are at 0.
    """
    x = target.x_nominal.copy()
    x[:7], x[target.nq : target.nq + 6] = state[:7], state[source.nq : source.nq + 6]
    at = {name: i for i, name in enumerate(source.description.actuated_joints)}
    for i, name in enumerate(target.description.actuated_joints):
        if name in at:
            x[target.actuated_q[i]] = state[source.actuated_q[at[name]]]
            x[target.nq + target.actuated_v[i]] = state[source.nq + source.actuated_v[at[name]]]
    return x


def _mass(link: ET.Element) -> float:
    return float(part_of(link, "inertial/mass").get("value", "0"))


def _scale(link: ET.Element, factor: float) -> None:
    """Multiply mass and inertia of a link."""
    for path in ("inertial/mass", "inertial/inertia"):
        for key, value in (element := part_of(link, path)).attrib.items():
            element.set(key, repr(float(value) * factor))
