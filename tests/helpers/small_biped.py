"""A second robot, described without touching code."""

import shutil

import yaml

_LEG = (  # joint, axis, origin (y of the left side), rpy
    ("yaw", (0, 0, 1), (0.0, 0.1, -0.05), (0, 0, 0)),
    ("roll", (1, 0, 0), (0.0, 0.0, -0.06), (0, 0.2, 0)),
    ("pitch", (0, 1, 0), (0.01, 0.02, 0.0), (0, -0.2, 0)),
    ("knee", (0, 1, 0), (0.0, 0.0, -0.3), (0, 0, 0)),
    ("ankle", (0, 1, 0), (0.0, 0.0, -0.3), (0, 0, 0)),
)
_ARM = (
    ("shoulder", (0, 1, 0), (0.0, 0.15, 0.3), (0, 0, 0)),
    ("elbow", (0, 1, 0), (0.0, 0.02, -0.2), (0, 0, 0)),
)
_LINK = """<link name="{name}"><inertial><origin xyz="{x} {y} {z}"/><mass value="{mass}"/>
<inertia ixx="{i}" iyy="{i}" izz="{i}" ixy="0" ixz="0" iyz="0"/></inertial></link>"""
_JOINT = """<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>
<origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="{axis}"/>
<limit lower="{lower}" upper="{upper}" velocity="20" effort="150"/></joint>"""
_MOTOR = """<transmission name="{name}_motor"><type>transmission_interface/SimpleTransmission</type>
<joint name="{name}"/><actuator name="{name}_motor"/></transmission>"""


def _text(numbers):
    return " ".join(str(float(number)) for number in numbers)


def _chain(side, chain):
    """Return links and joints of a limb; the right side turns the other way about x."""
    sign = {"L": 1.0, "R": -1.0}[side]
    parts, parent = [], "pelvis"
    for joint, axis, (x, y, z), rpy in chain:
        name = f"{joint}_{side}"
        limits = (0.0, 2.0) if joint == "knee" else (-1.2, 1.2)
        parts.append(_LINK.format(name=f"{name}_link", x=0.01, y=0, z=-0.1, mass=1.0, i=0.01))
        parts.append(
            _JOINT.format(
                name=name,
                parent=parent,
                child=f"{name}_link",
                xyz=_text((x, sign * y, z)),
                rpy=_text(rpy),
                axis=_text((sign * axis[0], axis[1], axis[2])),
                lower=limits[0],
                upper=limits[1],
            )
        )
        parent = f"{name}_link"
    return parts


def write_small_biped(folder, arms):
    """Write a small biped's URDF and description to a folder; return the description's path.

    Its motors are in another order than its joints, its right roll axes point the other way.
    """
    limbs = [_LEG, _ARM] if arms else [_LEG]
    joints = [[f"{j[0]}_{side}" for limb in limbs for j in limb] for side in "LR"]
    order = [name for pair in zip(*joints, strict=True) for name in pair]
    parts = [_LINK.format(name="pelvis", x=0.02, y=0, z=0.15, mass=6.0, i=0.1)]
    for side in "LR":
        for limb in limbs:
            parts += _chain(side, limb)
    parts += [_MOTOR.format(name=name) for name in order]
    model = folder / "small.urdf"
    model.write_text('<robot name="small">' + "\n".join(parts) + "</robot>")
    posture = {"pitch": -0.4, "knee": 0.8, "ankle": -0.4}
    points = [[-0.06, 0.0, -0.03], [0.08, 0.0, -0.03]]
    description = {
        "name": "Small biped",
        "model": model.name,
        "floating_base": "pelvis",
        "actuated_joints": order,
        "feet": [
            {
                "name": name,
                "frame": f"ankle_{side}_link",
                "contact_points": points,
                "leg_joints": [f"{joint[0]}_{side}" for joint in _LEG],
            }
            for name, side in (("left", "L"), ("right", "R"))
        ],
        "arm_joints": [f"{j[0]}_{side}" for side in "LR" for j in _ARM] if arms else [],
        "mirror": {
            left: [right, -1 if left == "yaw_L" else 1] for left, right in zip(*joints, strict=True)
        },
        "nominal_posture": {f"{j}_{side}": a for j, a in posture.items() for side in "LR"},
        "limits": {
            "step_length": 0.3,
            "step_width_min": 0.1,
            "step_width_max": 0.4,
            "com_height_min": 0.4,
            "com_height_max": 0.58,
        },
    }
    file = folder / "small.yaml"
    file.write_text(yaml.safe_dump(description, sort_keys=False))
    return file


def copied(file, folder):
    """Copy a description with its folder, for a test that writes beside it; return the copy."""
    return shutil.copytree(file.parent, folder) / file.name
