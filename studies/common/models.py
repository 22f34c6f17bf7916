"""Robots made from a shipped one: heavier legs, no arms, more joints, frames for PlaCo."""

import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import yaml

from drake_linefoot.errors import InputError
from drake_linefoot.robot.humanoid import Humanoid, load_humanoid
from drake_linefoot.scenario import Scenario
from studies.common.types import Array

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


class Model:
    """The URDF of a robot, to be changed; there is nothing to look at in it.

    Attributes:
        root: of the file.
        links, joints: its elements by name, as they were read.
    """

    def __init__(self, humanoid: Humanoid, collisions: bool = False) -> None:
        """Read it, with or without what collides."""
        ET.register_namespace("drake", "https://drake.mit.edu")  # else its tags lose their name
        self._tree = ET.parse(humanoid.description.model)
        self.root = self._tree.getroot()
        self.links, self.joints = (
            {str(part.get("name")): part for part in self.root.findall(kind)}
            for kind in ("link", "joint")
        )
        for link in self.links.values():
            for part in [
                *link.findall("visual"),
                *([] if collisions else link.findall("collision")),
            ]:
                link.remove(part)

    def child(self, joint: str) -> ET.Element:
        """Return the link that hangs on a joint."""
        return self.links[str(part_of(self.joints[joint], "child").get("link"))]

    def add(self, text: str, **values: object) -> None:
        """Add the elements of a template."""
        self.root.extend(ET.fromstring(text.format(**values)))

    def write(self, file: Path) -> None:
        """Write it."""
        self._tree.write(file, encoding="unicode", xml_declaration=True)

    def load(
        self, humanoid: Humanoid, file: Path, joints: tuple[str, ...], arms: tuple[str, ...]
    ) -> Humanoid:
        """Write it and load it.

        Args:
            humanoid: the robot it was made from.
            file: to write.
            joints: that have motors.
            arms: those of them that are the arms'.
        """
        self.write(file)
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
    description, model = original.description, Model(original, collisions=True)
    legs = [model.child(name) for foot in description.feet for name in foot.leg_joints]
    torso = model.links[description.floating_base]
    given = (1.0 - factor) * sum(_mass(link) for link in legs)
    share = 1.0 + given / _mass(torso)
    if not (factor > 0.0 and share > 0.0):
        raise InputError("leg mass", "factor", factor, "must be positive and leave the torso some")
    for link in legs:
        _scale(link, factor)
    _scale(torso, share)
    urdf = folder / f"legs_{factor:g}.urdf"
    model.write(urdf)
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
    return float(humanoid.plant.CalcCenterOfMassPositionInWorld(context)[2])


def leg_share(humanoid: Humanoid) -> float:
    """Return the legs' share of the mass [-]."""
    plant = humanoid.plant
    context = plant.CreateDefaultContext()
    names = [name for foot in humanoid.description.feet for name in foot.leg_joints]
    masses = [plant.GetJointByName(name).child_body().get_mass(context) for name in names]
    return float(sum(masses)) / humanoid.mass


def without_arms(humanoid: Humanoid, folder: Path) -> Humanoid:
    """Return the robot with its arms welded in their zero posture; the model is in `folder`."""
    model, d = Model(humanoid), humanoid.description
    for name in d.arm_joints:
        joint = model.joints[name]
        joint.set("type", "fixed")
        for part in [p for p in joint if p.tag not in ("parent", "child", "origin")]:
            joint.remove(part)
    for transmission in model.root.findall("transmission"):
        if part_of(transmission, "joint").get("name") in d.arm_joints:
            model.root.remove(transmission)
    joints = tuple(name for name in d.actuated_joints if name not in d.arm_joints)
    return model.load(humanoid, folder / "without_arms.urdf", joints, ())


def with_extra_joints(humanoid: Humanoid, folder: Path) -> Humanoid:
    """Return the robot with a chain of five more joints on its torso, as a neck would be."""
    model, d = Model(humanoid), humanoid.description
    pattern = ET.tostring(part_of(model.root, "transmission"))
    names, parent = tuple(f"extra_{i}" for i in range(len(EXTRA_AXES))), d.floating_base
    for name, axis in zip(names, EXTRA_AXES, strict=True):
        model.add(_EXTRA, name=name, parent=parent, axis=axis, mass=EXTRA_MASS)
        parent = f"{name}_link"
        transmission = ET.fromstring(pattern)
        transmission.set("name", f"{name}_transmission")
        for tag in ("joint", "actuator"):
            part_of(transmission, tag).set("name", name)
        model.root.append(transmission)
    file = folder / "with_extra_joints.urdf"
    return model.load(humanoid, file, (*d.actuated_joints, *names), (*d.arm_joints, *names))


def for_placo(humanoid: Humanoid, file: Path) -> None:
    """Write the model with a frame in the middle of each contact line, `SIDE_line`."""
    model = Model(humanoid)
    for foot, p_FC in zip(humanoid.description.feet, humanoid.p_FC, strict=True):
        xyz = " ".join(map(repr, p_FC.tolist()))
        model.add(_LINE, name=foot.name, frame=foot.frame, xyz=xyz)
    model.write(file)


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


def part_of(element: ET.Element, path: str) -> ET.Element:
    """Return a part that every model has."""
    part = element.find(path)
    if part is None:
        raise InputError(element.get("name", element.tag), path, None, "is missing in the model")
    return part


def _mass(link: ET.Element) -> float:
    return float(part_of(link, "inertial/mass").get("value", "0"))


def _scale(link: ET.Element, factor: float) -> None:
    """Multiply mass and inertia of a link."""
    for path in ("inertial/mass", "inertial/inertia"):
        for key, value in (element := part_of(link, path)).attrib.items():
            element.set(key, repr(float(value) * factor))
