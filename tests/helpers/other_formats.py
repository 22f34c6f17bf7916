"""The MIT Humanoid's tree of links and joints, written as SDF and as MJCF."""

from tests.helpers.made_up_robots import numbers

INERTIA = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


def parts_of(tree):
    """Return the joint above each link by the link's name, and the names of its children."""
    joints = {j.find("child").get("link"): j for j in tree.getroot().findall("joint")}
    below = {link.get("name"): [] for link in tree.getroot().findall("link")}
    for child, joint in joints.items():
        below[joint.find("parent").get("link")].append(child)
    return joints, below


def words(values):
    return " ".join(repr(float(value)) for value in values)


def sdf_sphere(collision):
    """Return a sphere of URDF as SDF has it."""
    place = words(numbers(collision.find("origin"), "xyz"))
    radius = collision.find("geometry/sphere").get("radius")
    return (
        f'<collision name="{collision.get("name")}"><pose>{place} 0 0 0</pose>'
        f"<geometry><sphere><radius>{radius}</radius></sphere></geometry></collision>"
    )


def as_sdf(tree):
    """Return a robot as SDF, without drawings."""
    joints, _ = parts_of(tree)
    out = []
    for link in tree.getroot().findall("link"):
        name, inertial = link.get("name"), link.find("inertial")
        inside = "".join(f"<{k}>{inertial.find('inertia').get(k)}</{k}>" for k in INERTIA)
        pose = f'<pose relative_to="{joints[name].get("name")}"/>' if name in joints else ""
        shapes = "".join(map(sdf_sphere, link.findall("collision")))
        out.append(
            f'<link name="{name}">{pose}<inertial><pose>'
            f"{words(numbers(inertial.find('origin'), 'xyz'))} 0 0 0</pose>"
            f"<mass>{inertial.find('mass').get('value')}</mass><inertia>{inside}</inertia>"
            f"</inertial>{shapes}</link>"
        )
    for child, joint in joints.items():
        origin, limit = joint.find("origin"), joint.find("limit")
        limits = "".join(f"<{k}>{limit.get(k)}</{k}>" for k in ("lower", "upper", "effort"))
        out.append(
            f'<joint name="{joint.get("name")}" type="revolute">'
            f'<pose relative_to="{joint.find("parent").get("link")}">'
            f"{words(numbers(origin, 'xyz'))} {words(numbers(origin, 'rpy'))}</pose>"
            f"<parent>{joint.find('parent').get('link')}</parent><child>{child}</child>"
            f"<axis><xyz>{joint.find('axis').get('xyz')}</xyz><limit>{limits}"
            f"<velocity>{limit.get('velocity')}</velocity></limit></axis></joint>"
        )
    return f'<sdf version="1.9"><model name="biped">{"".join(out)}</model></sdf>'


def as_mjcf(tree):
    """Return a robot as MJCF, without drawings."""
    joints, below = parts_of(tree)

    def body(name):
        link = next(e for e in tree.getroot().findall("link") if e.get("name") == name)
        inertial = link.find("inertial")
        inertia = " ".join(inertial.find("inertia").get(k) for k in INERTIA)
        text = f'<body name="{name}"'
        if name in joints:
            origin, limit = joints[name].find("origin"), joints[name].find("limit")
            text += (
                f' pos="{words(numbers(origin, "xyz"))}" euler="{words(numbers(origin, "rpy"))}">'
            )
            text += f'<joint name="{joints[name].get("name")}" type="hinge" '
            text += f'axis="{joints[name].find("axis").get("xyz")}" limited="true" '
            text += f'range="{limit.get("lower")} {limit.get("upper")}"/>'
        else:
            text += "><freejoint/>"
        text += f'<inertial pos="{words(numbers(inertial.find("origin"), "xyz"))}" '
        text += f'mass="{inertial.find("mass").get("value")}" fullinertia="{inertia}"/>'
        for shape in link.findall("collision"):
            text += f'<geom type="sphere" pos="{words(numbers(shape.find("origin"), "xyz"))}" '
            text += f'size="{shape.find("geometry/sphere").get("radius")}"/>'
        return text + "".join(body(child) for child in below[name]) + "</body>"

    root = next(name for name in below if name not in joints)
    motors = "".join(
        f'<motor name="{j.get("name")}" joint="{j.get("name")}" ctrllimited="true" '
        f'ctrlrange="-{j.find("limit").get("effort")} {j.find("limit").get("effort")}"/>'
        for j in joints.values()
    )
    return (
        '<mujoco model="biped"><compiler angle="radian" eulerseq="XYZ"/>'
        f"<worldbody>{body(root)}</worldbody><actuator>{motors}</actuator></mujoco>"
    )
