"""A biped with legs of six joints and box feet, of any mass and with soles of any size."""

MASS, THIGH, SHANK, ANKLE = 33.0, 0.32, 0.32, 0.06  # [kg], [m] of a robot of size 1
_INERTIAL = """<inertial><origin xyz="{at}"/><mass value="{mass}"/>
<inertia ixx="{i[0]}" iyy="{i[1]}" izz="{i[2]}" ixy="0" ixz="0" iyz="0"/></inertial>"""
_LINK = '<link name="{name}">{inertial}{shape}</link>'
_BOX = """<collision><origin xyz="{at}"/><geometry><box size="{size}"/></geometry></collision>"""
_JOINT = """<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>
<origin xyz="{at}"/><axis xyz="{axis}"/>
<limit lower="{lower}" upper="{upper}" velocity="{velocity}" effort="{effort}"/></joint>"""
_LEG = (  # joint, axis, origin in size 1, limits, effort [N m], mass of its link, its height
    ("hip_yaw", "0 0 1", (0.0, 0.08, -0.05), (-0.6, 0.6), 60.0, 0.8, 0.06),
    ("hip_roll", "1 0 0", (0.0, 0.0, -0.04), (-0.4, 0.6), 120.0, 0.8, 0.06),
    ("hip_pitch", "0 1 0", (0.0, 0.0, 0.0), (-1.8, 1.0), 120.0, 3.4, THIGH),
    ("knee", "0 1 0", (0.0, 0.0, -THIGH), (0.0, 2.3), 160.0, 2.0, SHANK),
    ("ankle_pitch", "0 1 0", (0.0, 0.0, -SHANK), (-1.0, 0.8), 80.0, 0.2, 0.04),
    ("ankle_roll", "1 0 0", (0.0, 0.0, 0.0), (-0.5, 0.5), 60.0, 0.8, ANKLE),
)
HEIGHT = 0.02  # [m] of a foot's box, at any size


def _text(numbers):
    return " ".join(repr(float(number)) for number in numbers)


def _link(name, mass, size, at, shape=""):
    """Return a link that is a box of its mass [kg] and size [m] about a place."""
    x, y, z = size
    inertia = [mass * (a * a + b * b) / 12.0 for a, b in ((y, z), (x, z), (x, y))]
    inertial = _INERTIAL.format(at=_text(at), mass=mass, i=inertia)
    return _LINK.format(name=name, inertial=inertial, shape=shape)


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
    size, heavy = (mass / MASS) ** (1.0 / 3.0), mass / MASS
    torso = MASS - 2.0 * sum(joint[5] for joint in _LEG[:joints])
    box = [size * x for x in (0.16, 0.3, 0.45)]
    parts = [_link("torso", heavy * torso, box, (0.0, 0.0, size * 0.2))]
    for side, sign in (("left", 1.0), ("right", -1.0)):
        parent = "torso"
        for name, axis, (x, y, z), limits, effort, of_link, long in _LEG[:joints]:
            child, foot = f"{side}_{name}_link", name == _LEG[joints - 1][0]
            bound = effort * heavy * size
            if name == "ankle_roll" and roll_effort is not None:
                bound = roll_effort
            mirrored = sign < 0.0 and axis != "0 1 0"
            bounds = sorted(-x for x in limits) if mirrored else limits
            place = _text((size * x, size * sign * y, size * z))
            parts.append(
                _JOINT.format(
                    **{"name": f"{side}_{name}", "parent": parent, "child": child, "at": place},
                    **{"axis": axis, "lower": bounds[0], "upper": bounds[1], "effort": bound},
                    velocity=15.0 * size**-0.5,
                )
            )
            at, form, shape = (0.0, 0.0, -0.5 * size * long), [size * w for w in (0.09, 0.09)], ""
            form.append(size * long)
            if foot:
                form, at = [length, width, HEIGHT], (0.1 * length, 0.0, 0.5 * HEIGHT - size * ANKLE)
                shape = _BOX.format(at=_text(at), size=_text(form))
            parts.append(_link(child, heavy * of_link, form, at, shape))
            parent = child
    file = folder / "sole_biped.urdf"
    file.write_text('<robot name="sole_biped">' + "\n".join(parts) + "</robot>")
    return file
