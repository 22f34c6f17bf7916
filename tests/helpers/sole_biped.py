"""A biped with legs of six joints and box feet, of any mass and with soles of any size."""

import math

import yaml

from drake_linefoot.lab.new_robot.analysis import analyse
from studies.common.models import read
from studies.zoo.made_up import SIDES, Y_UP, turn_frame
from studies.zoo.soled import BIPED, write_soled

MASS = BIPED.mass  # [kg] of a robot of size 1


def write_sole_biped(folder, length=0.17, width=0.06, mass=MASS, joints=6, roll_effort=None):
    """Write the URDF of a biped without arms; return its file.

    A robot of another mass has another size, as dense; its soles are as given.

    Args:
        folder: where `sole_biped.urdf` is written.
        length: of its soles, 40 % of it behind the ankle [m].
        width: of its soles [m].
        mass: of the robot [kg].
        joints: of a leg: six, or five without ankle rolls.
        roll_effort: torque limit of the ankle rolls [N m]; None: as strong as the rest.
    """
    *leg, foot = BIPED.leg[:joints]
    if foot.name == "ankle_roll" and roll_effort is not None:
        foot = foot._replace(effort=roll_effort * (MASS / mass) ** (4.0 / 3.0))
    foot = foot._replace(length=BIPED.leg[-1].length)  # as high without an ankle roll
    design = BIPED._replace(leg=(*leg, foot))
    return write_soled(folder, "sole_biped", design, (length, width), mass)


def write_turned_biped(folder):
    """Write the biped, y up in the links of its feet, and its description; return the latter."""
    model = write_sole_biped(folder)
    tree = read(model)
    for side in SIDES:
        turn_frame(tree, f"{side}_ankle_roll_link", Y_UP)
    tree.write(model, encoding="utf-8")
    data = analyse(model).data
    for foot in data["feet"]:
        foot["pose"]["rpy"] = [-0.5 * math.pi, 0.0, 0.0]  # not to some digits
    file = folder / "sole_biped.yaml"
    file.write_text(yaml.safe_dump(data, sort_keys=False), encoding="utf-8")
    return file
