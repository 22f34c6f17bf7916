"""Variants of a robot whose legs have another share of its mass."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import yaml

from drake_linefoot.errors import InputError
from drake_linefoot.robot.humanoid import Humanoid, load_humanoid
from drake_linefoot.scenario import Scenario


def leg_mass_variant(robot: str | Path, factor: float, folder: Path) -> Path:
    """Write a robot with heavier or lighter legs and the same total mass.

    Mass and inertia of every link from the hip to the foot are multiplied by `factor`; the
    torso gets (or gives) the difference, its inertia in proportion. Centres of mass, joints,
    limits and reflected inertias stay. The limits on the height of the CoM move with the CoM of
    the nominal posture. There are no visuals.

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
    description = original.description
    ET.register_namespace("drake", "https://drake.mit.edu")  # else its tags lose their name
    tree = ET.parse(description.model)
    links = {link.get("name"): link for link in tree.getroot().findall("link")}
    joints = {joint.get("name"): joint for joint in tree.getroot().findall("joint")}
    legs = [links[_child(joints[name])] for foot in description.feet for name in foot.leg_joints]
    torso = links[description.floating_base]
    given = (1.0 - factor) * sum(_mass(link) for link in legs)
    share = 1.0 + given / _mass(torso)
    if not (factor > 0.0 and share > 0.0):
        raise InputError("leg mass", "factor", factor, "must be positive and leave the torso some")
    for link in legs:
        _scale(link, factor)
    _scale(torso, share)
    for link in links.values():
        for visual in link.findall("visual"):
            link.remove(visual)
    model = folder / f"legs_{factor:g}.urdf"
    tree.write(model, encoding="unicode", xml_declaration=True)
    data = yaml.safe_load(description.file.read_text(encoding="utf-8"))
    data["name"], data["model"] = f"{description.name}, legs x {factor:g}", model.name
    file = model.with_suffix(".yaml")
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


def _child(joint: ET.Element) -> str:
    child = joint.find("child")
    return "" if child is None else str(child.get("link"))


def _mass(link: ET.Element) -> float:
    mass = link.find("inertial/mass")
    return 0.0 if mass is None else float(mass.get("value", "0"))


def _scale(link: ET.Element, factor: float) -> None:
    """Multiply mass and inertia of a link."""
    for path in ("inertial/mass", "inertial/inertia"):
        element = link.find(path)
        if element is not None:
            for key, value in element.attrib.items():
                element.set(key, repr(float(value) * factor))
