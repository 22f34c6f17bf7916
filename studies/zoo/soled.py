"""Robots of boxes with six joints a leg and soles, of any mass; without arms."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

HEIGHT = 0.02  # [m] of a foot's box, at any size
THICK = 0.09  # [m] of a leg's boxes
_ACROSS = "0 1 0"
_INERTIAL = """<inertial><origin xyz="{at}"/><mass value="{mass}"/>
<inertia ixx="{i[0]}" iyy="{i[1]}" izz="{i[2]}" ixy="0" ixz="0" iyz="0"/></inertial>"""
_LINK = '<link name="{name}">{inertial}{shape}</link>'
_BOX = """<collision><origin xyz="{at}"/><geometry><box size="{size}"/></geometry></collision>"""
_JOINT = """<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>
<origin xyz="{at}"/><axis xyz="{axis}"/>
<limit lower="{limits[0]}" upper="{limits[1]}" velocity="{speed}" effort="{effort}"/></joint>"""


class Joint(NamedTuple):
    """A joint of the left leg and the link that it moves.

    Attributes:
        name: without the side.
        axis: of it, "x y z".
        place: in the link before [m].
        limits: [rad].
        effort: [N m].
        speed: [rad/s].
        mass: of the link [kg].
        length: of the link, downwards [m]; of the last one how far the sole is below the joint.
    """

    name: str
    axis: str
    place: tuple[float, float, float]
    limits: tuple[float, float]
    effort: float
    speed: float
    mass: float
    length: float


class Design(NamedTuple):
    """A robot: its mass [kg], the box of its torso [m], how high that is [m], and a leg."""

    mass: float
    torso: tuple[float, float, float]
    middle: float
    leg: tuple[Joint, ...]


BIPED = Design(
    33.0,
    (0.16, 0.3, 0.45),
    0.2,
    (
        Joint("hip_yaw", "0 0 1", (0.0, 0.08, -0.05), (-0.6, 0.6), 60.0, 15.0, 0.8, 0.06),
        Joint("hip_roll", "1 0 0", (0.0, 0.0, -0.04), (-0.4, 0.6), 120.0, 15.0, 0.8, 0.06),
        Joint("hip_pitch", _ACROSS, (0.0, 0.0, 0.0), (-1.8, 1.0), 120.0, 15.0, 3.4, 0.32),
        Joint("knee", _ACROSS, (0.0, 0.0, -0.32), (0.0, 2.3), 160.0, 15.0, 2.0, 0.32),
        Joint("ankle_pitch", _ACROSS, (0.0, 0.0, -0.32), (-1.0, 0.8), 80.0, 15.0, 0.2, 0.04),
        Joint("ankle_roll", "1 0 0", (0.0, 0.0, 0.0), (-0.5, 0.5), 60.0, 15.0, 0.8, 0.06),
    ),
)
H1_2 = Design(  # about what is published of it, its arms in the torso
    68.0,
    (0.2, 0.35, 0.6),
    0.25,
    (
        Joint("hip_yaw", "0 0 1", (0.0, 0.0875, -0.16), (-0.43, 0.43), 200.0, 23.0, 2.8, 0.06),
        Joint("hip_pitch", _ACROSS, (0.0, 0.0755, 0.0), (-3.1, 2.5), 200.0, 23.0, 2.1, 0.06),
        Joint("hip_roll", "1 0 0", (0.0, 0.0, 0.0), (-0.43, 3.1), 200.0, 23.0, 3.9, 0.4),
        Joint("knee", _ACROSS, (0.0, 0.0, -0.4), (-0.12, 2.19), 300.0, 14.0, 4.2, 0.4),
        Joint("ankle_pitch", _ACROSS, (0.0, 0.0, -0.4), (-0.9, 0.52), 60.0, 9.0, 0.1, 0.04),
        Joint("ankle_roll", "1 0 0", (0.0, 0.0, -0.02), (-0.26, 0.26), 40.0, 9.0, 0.7, 0.05),
    ),
)


def write_soled(
    folder: Path, name: str, design: Design, sole: tuple[float, float], mass: float | None = None
) -> Path:
    """Write the URDF of a robot; return its file.

    Args:
        folder: where `NAME.urdf` is written.
        name: of it.
        design: what it is made of.
        sole: length, 40 % of it behind the ankle, and width of its soles [m].
        mass: of a robot of another size, as dense, whose soles are as given [kg].
    """
    heavy = 1.0 if mass is None else mass / design.mass
    size = heavy ** (1.0 / 3.0)
    torso = heavy * (design.mass - 2.0 * sum(joint.mass for joint in design.leg))
    box = [size * x for x in design.torso]
    parts = [_link("torso", torso, box, (0.0, 0.0, size * design.middle), "")]
    for side, sign in (("left", 1.0), ("right", -1.0)):
        parent = "torso"
        for joint in design.leg:
            child, (x, y, z) = f"{side}_{joint.name}_link", joint.place
            mirrored = sign < 0.0 and joint.axis != _ACROSS
            limits = [-joint.limits[1], -joint.limits[0]] if mirrored else joint.limits
            parts.append(
                _JOINT.format(
                    **{"name": f"{side}_{joint.name}", "parent": parent, "child": child},
                    **{"at": _text((size * x, size * sign * y, size * z)), "axis": joint.axis},
                    **{"limits": limits, "speed": joint.speed * size**-0.5},
                    effort=joint.effort * heavy * size,
                )
            )
            form, shape = [size * THICK, size * THICK, size * joint.length], ""
            at = (0.0, 0.0, -0.5 * size * joint.length)
            if joint is design.leg[-1]:
                length, width = sole
                form, at = [length, width, HEIGHT], (0.1 * length, 0.0, 0.5 * HEIGHT + 2.0 * at[2])
                shape = _BOX.format(at=_text(at), size=_text(form))
            parts.append(_link(child, heavy * joint.mass, form, at, shape))
            parent = child
    file = folder / f"{name}.urdf"
    file.write_text(f'<robot name="{name}">' + "\n".join(parts) + "</robot>", encoding="utf-8")
    return file


def _link(name: str, mass: float, size: Sequence[float], at: Iterable[float], shape: str) -> str:
    """Return a link that is a box of its mass [kg] and size [m] about a place."""
    x, y, z = size
    inertia = [mass * (a * a + b * b) / 12.0 for a, b in ((y, z), (x, z), (x, y))]
    inertial = _INERTIAL.format(at=_text(at), mass=mass, i=inertia)
    return _LINK.format(name=name, inertial=inertial, shape=shape)


def _text(numbers: Iterable[float]) -> str:
    return " ".join(repr(float(number)) for number in numbers)
