"""The robots of the zoo: where their models are, or how they are made."""

from collections.abc import Callable
from functools import partial
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

from drake_linefoot.robot.scaling import COM_HEIGHT, MASS
from studies.common.models import Tree
from studies.zoo import made_up
from studies.zoo.soled import BIPED, H1_2, write_soled

PACKAGE = "example-robot-data"  # its models are installed from PyPI, none is part of this project
ROOT = Path("cmeel.prefix/share/example-robot-data/robots")  # in its files
G1 = "g1_29dof_rev_1_0"
PUBLISHED = {
    G1: "g1_description/urdf",
    "talos_reduced": "talos_data/robots",
    "icub_reduced": "icub_description/robots",
    "romeo_small": "romeo_description/urdf",
    "simple_humanoid": "simple_humanoid_description/urdf",
    "alexander_v1.lowerBodyOnly": "alexander_description/urdf",
    "human": "human_description/robots",
    "bolt": "bolt_description/robots",
}
HEAVY, HEAVY_ANKLE = "heavy_weak_ankles", 40.0  # [N m]
SMALL, SMALL_HEIGHT, SMALL_MASS = "small", 0.22, 2.0  # [m] of its CoM, [kg]
HEAVY_MASS = 59.0  # [kg]
SOLED_MASS, SOLE = 60.0, (0.2, 0.05)  # [kg], length and width [m]
H1_2_SOLE = (0.25, 0.09)  # [m]

Change = Callable[[Tree], None]
Maker = Callable[[Path, str], Path]  # of a folder and the robot's name; returns the model's file


def _cubed(tree: Tree, mass: float) -> None:
    """Make a robot of another mass [kg] that has the same density."""
    made_up.scale_all(tree, (mass / MASS) ** (1.0 / 3.0), mass / MASS)


def _heavy(tree: Tree) -> None:
    _cubed(tree, HEAVY_MASS)
    made_up.limit_ankles(tree, HEAVY_ANKLE)


CHANGES: dict[str, tuple[str, Change]] = {  # of the MIT Humanoid
    "mit_humanoid": ("as it is", lambda tree: None),
    "short_legs": ("legs half as long", partial(made_up.scale_legs, share=0.5)),
    "long_legs": ("legs twice as long", partial(made_up.scale_legs, share=2.0)),
    "backward_knees": ("knees that bend the other way", made_up.turn_knees),
    "other_order": ("joints in another order", made_up.shuffle),
    "y_up_feet": ("frames of the feet with y up", made_up.turn_feet),
    "waist": ("a pelvis of its own, with a waist yaw", made_up.add_waist),
    "no_arms": ("no arms", made_up.drop_arms),
    HEAVY: (f"{HEAVY_MASS:g} kg, as dense; ankles of {HEAVY_ANKLE:g} N m", _heavy),
    "half_mass": ("half the mass, as dense", partial(_cubed, mass=0.5 * MASS)),
    SMALL: (
        f"{SMALL_HEIGHT:g} m, {SMALL_MASS:g} kg",
        partial(made_up.scale_all, length=SMALL_HEIGHT / COM_HEIGHT, mass=SMALL_MASS / MASS),
    ),
    "point_feet": ("feet that are points", partial(made_up.put_soles, heel=0.0, toe=0.0)),
}


def _changed(change: Change, folder: Path, name: str) -> Path:
    tree = made_up.mit()
    change(tree)
    return made_up.write(tree, folder, name)


MADE_UP: dict[str, tuple[str, Maker]] = {
    **{name: (what, partial(_changed, change)) for name, (what, change) in CHANGES.items()},
    "soled_60": (
        f"boxes, {SOLED_MASS:g} kg, soles of {1e3 * SOLE[1]:g} x {1e3 * SOLE[0]:g} mm",
        partial(write_soled, design=BIPED, sole=SOLE, mass=SOLED_MASS),
    ),
    "like_h1_2": (
        f"boxes, {H1_2.mass:g} kg, legs about as those of an H1-2",
        partial(write_soled, design=H1_2, sole=H1_2_SOLE),
    ),
}
QUICK = ("no_arms", "soled_60", "point_feet")


def published() -> tuple[dict[str, Path], str]:
    """Return the models of the package by name, and its name and version; nothing without it."""
    try:
        found = distribution(PACKAGE)
    except PackageNotFoundError:
        return {}, ""
    files = {n: Path(str(found.locate_file(ROOT / f / f"{n}.urdf"))) for n, f in PUBLISHED.items()}
    return files, f"{PACKAGE} {found.version}"


def make(name: str, folder: Path) -> Path:
    """Write a made-up robot; return its file."""
    return MADE_UP[name][1](folder, name)
