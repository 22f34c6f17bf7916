"""A robot with soles: the MIT Humanoid with an ankle roll and feet that have a width."""

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import yaml

from drake_linefoot.resources import models_dir
from drake_linefoot.robot.humanoid import load_humanoid
from tests.helpers.made_up_robots import SIDES, add_roll, box_feet, mit, write

WIDTH, MARGIN = 0.06, 0.005  # of the soles [m]
MADE_BY_HAND = ("actuated_joints", "arm_joints", "mirror")  # the model has more joints now


def write_soled(folder):
    """Write model and description to a folder; return the description's path."""
    tree = mit()
    add_roll(tree)
    box_feet(tree)
    shipped = models_dir() / "mit_humanoid" / "mit_humanoid.yaml"
    data = yaml.safe_load(shipped.read_text(encoding="utf-8"))
    for name in MADE_BY_HAND:
        del data[name]
    data |= {"model": str(write(tree, folder)), "contact": "surface", "contact_margin": MARGIN}
    for foot, side in zip(data["feet"], SIDES, strict=True):
        z = -0.06  # the underside of `box_feet`
        foot |= {"contact_points": [[-0.07, 0.0, z], [0.13, 0.0, z]], "contact_width": WIDTH}
        foot["leg_joints"].append(f"{side}_ankle_roll")
        data["feet"][SIDES.index(side)] = foot
    file = folder / "soled.yaml"
    file.write_text(yaml.safe_dump(data, sort_keys=False), encoding="utf-8")
    return file


@cache
def soled():
    """The robot; nothing in it changes."""
    with TemporaryDirectory() as folder:
        return load_humanoid(write_soled(Path(folder)))
