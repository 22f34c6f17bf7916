"""What is made of a model that other projects wrote, and what a description may not say of it."""

import copy
import re

import numpy as np
import pytest
import yaml

from drake_linefoot.errors import ModelError
from drake_linefoot.resources import models_dir
from drake_linefoot.robot.dynamics import robot_dynamics
from drake_linefoot.robot.humanoid import load_humanoid
from tests.helpers import made_up_robots as made_up

DATA = yaml.safe_load((models_dir() / "mit_humanoid" / "mit_humanoid.yaml").read_text("utf-8"))
DERIVED = ("actuated_joints", "arm_joints", "mirror")


def load(folder, tree=None, work=lambda data: None):
    """Load the MIT Humanoid with its model and its description changed."""
    data = copy.deepcopy(DATA)
    data["model"] = made_up.write(tree or made_up.mit(), folder).name
    work(data)
    file = folder / "changed.yaml"
    file.write_text(yaml.safe_dump(data), encoding="utf-8")
    return load_humanoid(file)


def without_lists(data):
    for key in DERIVED:
        del data[key]


# --- what a description may leave out -----------------------------------------------------------


def test_joints_arms_and_mirror_are_derived(tmp_path, humanoid):
    d = load(tmp_path, work=without_lists).description
    for key in DERIVED:
        assert getattr(d, key) == getattr(humanoid.description, key)


def test_a_joint_in_the_middle_is_its_own_mirror_image(tmp_path):
    tree = made_up.mit()
    made_up.add_waist(tree)

    def work(data):
        without_lists(data)
        data["floating_base"] = "pelvis"

    # No transmission is there for the waist, so its actuator comes last.
    robot = load(tmp_path, tree, work)
    assert robot.description.mirror["waist_yaw"] == ("waist_yaw", -1.0)
    at = robot.description.actuated_joints.index("waist_yaw")
    angles = np.arange(robot.na) / 10.0
    assert robot.mirror_joints(angles)[at] == -angles[at]
    np.testing.assert_array_equal(robot.mirror_joints(robot.mirror_joints(angles)), angles)


def test_a_locked_joint_weighs_as_it_did_at_its_angle(tmp_path, humanoid):
    angle = -0.4
    locked = ["left_elbow", "right_elbow"]

    def work(data):
        without_lists(data)
        data["lock"] = dict.fromkeys(locked, angle)

    robot = load(tmp_path, work=work)
    assert robot.na == humanoid.na - 2
    assert "2 joints locked: left_elbow, right_elbow" in robot.notes
    q = humanoid.q_nominal.copy()
    kept = [n for n in humanoid.description.actuated_joints if n not in locked]
    for name in locked:
        q[humanoid.actuated_q[humanoid.description.actuated_joints.index(name)]] = angle
    plain = robot_dynamics(humanoid, humanoid.scratch, np.concatenate([q, np.zeros(humanoid.nv)]))
    other = robot_dynamics(robot, robot.scratch, robot.x_nominal)
    assert list(robot.description.actuated_joints) == kept
    index = [humanoid.description.actuated_joints.index(n) for n in kept]
    rows = [*range(6), *humanoid.actuated_v[index]]
    mine = [*range(6), *robot.actuated_v]
    np.testing.assert_allclose(other.M[np.ix_(mine, mine)], plain.M[np.ix_(rows, rows)], atol=1e-12)
    np.testing.assert_allclose(other.p_WG, plain.p_WG, atol=1e-12)


# --- what is taken in, with a line --------------------------------------------------------------


def friction(tree):
    for joint in tree.getroot().findall("joint"):
        made_up.add_element(joint, "dynamics", friction="0.3", damping="0.1")


def odd_transmission(tree):
    tree.getroot().find("transmission").find("type").text = "DifferentialTransmission"


def mimic(tree):
    made_up.add_roll(tree)
    for side in made_up.SIDES:
        joint = made_up.named(tree, "joint", f"{side}_ankle_roll")
        made_up.add_element(joint, "mimic", joint=f"{side}_knee", multiplier="2")


def unknown_material(tree):
    made_up.add_element(next(tree.iter("visual")), "material", name="moonstone")


def fixed_hips(tree):
    """Fixed joints between torso and legs."""
    for joint in made_up.joints_of_legs(tree):
        if joint.find("parent").get("link") == "torso":
            name = joint.get("name")
            made_up.add_link(tree, f"{name}_plate", 0.0)
            made_up.add_joint(tree, f"{name}_weld", "torso", f"{name}_plate", "0 0 1", "fixed")
            joint.find("parent").set("link", f"{name}_plate")


def massless_root(tree):
    made_up.add_link(tree, "base_link", 0.0, first=True)
    made_up.add_joint(tree, "base_weld", "base_link", "torso", "0 0 1", "fixed")


TAKEN = {
    "friction": (friction, r"\d+ joints: friction left out", {}),
    "transmission": (odd_transmission, "1 transmissions: not of the simple kind", {}),
    "mimic": (mimic, "2 joints locked", {"lock": {"left_ankle_roll": 0, "right_ankle_roll": 0.0}}),
    "material": (unknown_material, "1 drawings: unknown material left out", {}),
    "no meshes": (made_up.lose_meshes, r"\d+ meshes: not found, left out", {}),
    "no transmissions": (made_up.drop_transmissions, "18 actuators made from effort limits", {}),
    "fixed hips": (fixed_hips, "", {}),
    "massless root": (massless_root, "", {"floating_base": "base_link"}),
}


@pytest.mark.parametrize("name", TAKEN)
def test_what_is_taken_in_is_said_in_a_line(tmp_path, humanoid, name):
    work, said, entries = TAKEN[name]
    tree = made_up.mit()
    work(tree)

    def describe(data):
        without_lists(data)
        data.update(entries)

    robot = load(tmp_path, tree, describe)
    assert len([note for note in robot.notes if re.match(said, note)]) == 1 or not said
    assert all("\n" not in note and len(note) < 250 for note in robot.notes)
    assert robot.na == humanoid.na
    added = 0.1 if name == "mimic" else 0.0  # of the two links more
    assert robot.mass == pytest.approx(humanoid.mass + added, abs=1e-9)
    assert robot.torso.name() == "torso"
    order = [
        robot.description.actuated_joints.index(n) for n in humanoid.description.actuated_joints
    ]
    np.testing.assert_array_equal(robot.effort_limits[order], humanoid.effort_limits)


def test_a_shipped_robot_is_taken_as_it_is(humanoid):
    assert humanoid.notes == ()


# --- what is wrong, by entry ---------------------------------------------------------------------


def put(path, value):
    def work(data):
        *way, last = path
        for key in way:
            data = data[key]
        data[last] = value

    return work


def swapped(data):
    """Left and right exchanged, in words only."""
    feet = data["feet"]
    for key in ("frame", "leg_joints"):
        feet[0][key], feet[1][key] = feet[1][key], feet[0][key]
    data["mirror"] = {right: [left, sign] for left, (right, sign) in data["mirror"].items()}


def posture(**angles):
    def work(data):
        for joint, angle in angles.items():
            for side in made_up.SIDES:
                data["nominal_posture"][f"{side}_{joint}"] = angle

    return work


OFF = [[-0.05, 0.0, -0.06], [0.1, 0.0, -0.06]]
WRONG = {
    "swapped legs": (swapped, "feet[0].frame", "must be on the left"),
    "straight legs": (
        posture(hip_pitch=0.0, knee=0.0, ankle=0.0),
        "nominal_posture",
        "must be bent",
    ),
    "tilted soles": (posture(ankle=-0.3), "nominal_posture", "soles must be flat"),
    "one knee": (
        put(("nominal_posture", "left_knee"), 0.5),
        "nominal_posture",
        "soles must be flat",
    ),
    "knee beyond its stop": (posture(knee=-0.9), "nominal_posture.left_knee", "must lie in"),
    "leaning": (posture(hip_pitch=-0.9, ankle=0.0), "nominal_posture", "over the lines"),
    "wrong sign": (
        put(("mirror", "left_knee"), ["right_knee", -1]),
        "mirror.left_knee",
        "must be 1",
    ),
    "wrong sign of an arm": (
        put(("mirror", "left_elbow"), ["right_elbow", -1]),
        "mirror.left_elbow",
        "must be 1",
    ),
    "points below the shapes": (
        lambda data: [foot.update(contact_points=OFF) for foot in data["feet"]],
        "feet[0].contact_points",
        "0.019 m off them along z",
    ),
    "points beyond the toe": (
        lambda data: [
            foot.update(contact_points=[[0.0, 0.0, -0.041], [0.15, 0.0, -0.041]])
            for foot in data["feet"]
        ],
        "feet[0].contact_points",
        "along x",
    ),
    "line across": (
        lambda data: [foot.update(pose={"rpy": [0.0, 0.0, 1.5707963]}) for foot in data["feet"]],
        "feet[0].frame",
        "x axis along the line",
    ),
    "foot upside down": (
        lambda data: [foot.update(pose={"rpy": [3.1415926, 0.0, 0.0]}) for foot in data["feet"]],
        "feet[0].frame",
        "z axis up",
    ),
    "backwards": (
        put(("floating_base_pose",), {"rpy": [0.0, 0.0, 3.1415926]}),
        "feet[0].frame",
        "ahead",
    ),
    "upside down": (
        put(("floating_base_pose",), {"rpy": [3.1415926, 0.0, 0.0]}),
        "feet[0].frame",
        "z axis up",
    ),
    "out of reach": (
        put(("limits", "com_height_max"), 0.9),
        "limits.com_height_max",
        "out of reach",
    ),
    "a stride out of reach": (put(("limits", "step_length"), 2.0), "limits.step_length", "reach"),
    "a lock of nothing": (put(("lock",), {"tail": 0.0}), "lock.tail", "no such joint"),
    "a lock beyond stops": (put(("lock",), {"left_elbow": 9.0}), "lock.left_elbow", "must lie in"),
    "a pose of two": (
        put(("floating_base_pose",), {"rpy": [0.0, 0.0]}),
        "floating_base_pose.rpy",
        "3 items",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_wrong_is_named_by_its_entry(tmp_path, name):
    work, entry, said = WRONG[name]
    with pytest.raises(ModelError) as caught:
        load(tmp_path, work=work)
    message = str(caught.value)
    assert message.startswith(f"{tmp_path / 'changed.yaml'}: {entry} = ")
    assert said in message
    assert "\n" not in message and "np." not in message
    assert len(message) < 300 + len(str(tmp_path))


NUMBERS = {
    "a foot of three": ("link/collision/origin", "xyz", "0 nan 0", "finite numbers"),
    "two for an axis": ("joint/axis", "xyz", "0 1", "Expected 3 values"),
    "a ball inside out": ("link/collision/geometry/sphere", "radius", "-1e300", "not be negative"),
    "a planet": ("link/collision/geometry/sphere", "radius", "1e300", "at most 100"),
    "a star": ("link/inertial/mass", "value", "1e300", "at most 100000"),
    "far away": ("joint/origin", "xyz", "1e300 0 0", "at most 1000"),
    "reversed limits": ("joint/limit", "lower", "9", "limits are reversed"),
    "a wide joint": ("joint/limit", "upper", "1e300", "must lie in"),
    "a joint that stands": ("joint/limit", "velocity", "0", "velocity limit must lie in"),
    "a strong motor": ("joint/limit", "effort", "1e300", "effort limit must lie in"),
    "negative damping": ("joint/dynamics", "damping", "-1", "not be negative"),
    "a gear backwards": ("transmission/actuator/{*}gear_ratio", "value", "-1", "at least 1e-06"),
    "a light rotor": ("transmission/actuator/{*}rotor_inertia", "value", "-1", "not be negative"),
    "no number": ("transmission/actuator/{*}rotor_inertia", "value", "x", "a finite number"),
    "slime": ("link/collision/{*}proximity_properties/{*}mu_static", "value", "-1", "negative"),
}


@pytest.mark.parametrize("name", NUMBERS)
def test_numbers_that_no_robot_has_are_refused(tmp_path, name):
    place, key, value, said = NUMBERS[name]
    tree = made_up.mit()
    element = tree.getroot().find(place)
    assert element.get(key)
    element.set(key, value)
    with pytest.raises(ModelError) as caught:
        load(tmp_path, tree)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value) and len(str(caught.value)) < 300 + 2 * len(str(tmp_path))


def test_a_mesh_of_a_name_too_long_is_left_out(tmp_path):
    tree = made_up.mit()
    next(tree.iter("mesh")).set("filename", "a" * 5000)
    assert any("meshes: not found" in note for note in load(tmp_path, tree).notes)


def test_a_mimic_joint_must_be_locked(tmp_path):
    tree = made_up.mit()
    mimic(tree)
    with pytest.raises(ModelError, match="left_ankle_roll follows another joint: must be locked"):
        load(tmp_path, tree, without_lists)


def test_legs_of_different_length_are_no_mirror_images(tmp_path):
    tree = made_up.mit()
    origin = made_up.named(tree, "joint", "left_knee").find("origin")
    made_up.put(origin, "xyz", made_up.numbers(origin, "xyz") + np.array([0, 0.04, 0]))
    with pytest.raises(ModelError, match="legs must be mirror images"):
        load(tmp_path, tree, without_lists)


def test_rounding_is_no_difference(tmp_path):
    def work(data):
        data["feet"][1]["contact_points"] = [[-0.05, 0.0, -0.041], [0.1 + 1e-10, 0.0, -0.041]]

    assert load(tmp_path, work=work).half_length == pytest.approx(0.075)
