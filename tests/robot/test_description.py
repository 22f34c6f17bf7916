"""Robot descriptions: what is read, and that every mistake is one line that names the entry."""

import copy
import dataclasses
import shutil

import numpy as np
import pytest
import yaml

from drake_linefoot.contact.contacts import LineContact
from drake_linefoot.contact.surface import SurfaceContact
from drake_linefoot.errors import InputError, ModelError
from drake_linefoot.resources import models_dir
from drake_linefoot.robot.description import load_description
from drake_linefoot.robot.humanoid import Humanoid, load_humanoid

SHIPPED = models_dir() / "mit_humanoid" / "mit_humanoid.yaml"
DATA = yaml.safe_load(SHIPPED.read_text(encoding="utf-8"))
DELETE = object()


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A copy of the robot's folder, where descriptions can be changed."""
    copied = tmp_path_factory.mktemp("models") / "robot"
    shutil.copytree(SHIPPED.parent, copied)
    return copied


def changed(path, value):
    """Return the shipped description with one entry replaced or deleted."""
    data = copy.deepcopy(DATA)
    *way, last = path
    inner = data
    for key in way:
        inner = inner[key]
    if value is DELETE:
        del inner[last]
    else:
        inner[last] = value
    return data


def refused(folder, data, entry):
    """Return the error of a description: one line with file and entry (... for any)."""
    file = folder / "changed.yaml"
    text = data if isinstance(data, str) else yaml.safe_dump(data, sort_keys=False)
    file.write_text(text, encoding="utf-8")
    with pytest.raises(ModelError) as caught:
        load_humanoid(file)
    error = caught.value
    assert isinstance(error, InputError)
    message = str(error)
    assert "\n" not in message
    assert message.startswith(f"{file}: {error.entry}" if error.entry else str(file))
    assert error.where == str(file)
    assert error.entry == entry or entry is ...
    assert error.allowed
    return error


# --- what is read ---------------------------------------------------------------------------


def test_the_shipped_description_is_what_the_file_says():
    d = load_description(SHIPPED)
    assert d.name == DATA["name"]
    assert d.model == SHIPPED.parent / DATA["model"]
    assert d.actuated_joints == tuple(DATA["actuated_joints"])
    assert d.arm_joints == tuple(DATA["arm_joints"])
    assert [foot.name for foot in d.feet] == ["left", "right"]
    for foot, data in zip(d.feet, DATA["feet"], strict=True):
        assert (foot.frame, foot.leg_joints) == (data["frame"], tuple(data["leg_joints"]))
        np.testing.assert_array_equal(foot.contact_points, data["contact_points"])
    assert d.mirror == {left: tuple(pair) for left, pair in DATA["mirror"].items()}
    assert d.nominal_posture == DATA["nominal_posture"]
    assert dataclasses.asdict(d.limits) == {**DATA["limits"], "swing_height_max": None}


def test_a_description_cannot_be_changed_by_accident():
    d = load_description(SHIPPED)
    with pytest.raises(dataclasses.FrozenInstanceError):
        d.name = "other"
    with pytest.raises(ValueError, match="read-only"):
        d.feet[0].contact_points[0, 0] = 1.0


def test_a_robot_can_be_loaded_by_name_text_and_path(humanoid):
    for name in (str(SHIPPED), SHIPPED):
        again = load_humanoid(name)
        assert again.description.actuated_joints == humanoid.description.actuated_joints
        np.testing.assert_array_equal(again.q_nominal, humanoid.q_nominal)


# --- entries that are wrong by themselves ---------------------------------------------------

LEG = DATA["feet"][0]["leg_joints"]
JOINTS = DATA["actuated_joints"]
HALF = {k: v for k, v in DATA["mirror"].items() if k != "left_knee"}

WRONG = [
    ("name", ("name",), DELETE),
    ("name", ("name",), 7),
    ("name", ("name",), ""),
    ("model", ("model",), None),
    ("colour", ("colour",), "red"),
    ("7", (7,), "red"),
    ("file", ("file",), "mine.yaml"),
    ("actuated_joints", ("actuated_joints",), "left_knee"),
    ("actuated_joints", ("actuated_joints",), [*JOINTS[:-1], 3]),
    ("actuated_joints", ("actuated_joints",), [*JOINTS[:-1], JOINTS[0]]),
    ("feet", ("feet",), DATA["feet"][:1]),
    ("feet", ("feet",), {"left": DATA["feet"][0]}),
    ("feet[0]", ("feet", 0), "left"),
    ("feet[0].name", ("feet", 0, "name"), "right"),
    ("feet[1].size", ("feet", 1, "size"), 43),
    ("feet[1].frame", ("feet", 1, "frame"), DELETE),
    ("feet[0].contact_points", ("feet", 0, "contact_points"), [[0.1, 0.0, -0.04]]),
    ("feet[0].contact_points", ("feet", 0, "contact_points"), [[0, 0, 0], [1, 0, 0], [2, 0, 0]]),
    ("feet[1].contact_points", ("feet", 1, "contact_points"), [[-0.05, 0.0], [0.1, 0.0]]),
    ("feet[1].contact_points", ("feet", 1, "contact_points"), [[-0.05, 0, 0], [0.1, 0, "x"]]),
    ("feet[1].contact_points", ("feet", 1, "contact_points"), [["-0.05", "0", "0"], [0.1, 0, 0]]),
    ("feet[1].contact_points", ("feet", 1, "contact_points"), [[-0.05, 0, 0], [np.inf, 0, 0]]),
    ("feet[1].contact_points", ("feet", 1, "contact_points"), [[0.1, 0, 0], [-0.05, 0, 0]]),
    ("feet[1].contact_points", ("feet", 1, "contact_points"), [[-0.05, 0, 0], [0.1, 0.01, 0]]),
    ("feet[0].leg_joints", ("feet", 0, "leg_joints"), [*LEG[:-1], LEG[0]]),
    ("mirror", ("mirror",), HALF),
    ("mirror", ("mirror",), [["left_knee", "right_knee"]]),
    ("mirror", ("mirror", 7), ["right_knee", 1]),
    ("mirror.left_knee", ("mirror", "left_knee"), ["right_knee", 2]),
    ("mirror.left_knee", ("mirror", "left_knee"), ["right_knee", True]),
    ("mirror.left_knee", ("mirror", "left_knee"), "right_knee"),
    ("mirror", ("mirror", "left_knee"), ["right_ankle", 1]),
    ("nominal_posture", ("nominal_posture",), 0.3),
    ("nominal_posture.tail", ("nominal_posture", "tail"), 0.3),
    ("nominal_posture.7", ("nominal_posture", 7), 0.3),
    ("nominal_posture.left_knee", ("nominal_posture", "left_knee"), np.nan),
    ("nominal_posture.left_knee", ("nominal_posture", "left_knee"), True),
    ("nominal_posture.left_knee", ("nominal_posture", "left_knee"), 10**400),
    ("limits", ("limits",), None),
    ("limits.step_length", ("limits", "step_length"), np.inf),
    ("limits.step_length", ("limits", "step_length"), 0.0),
    ("limits.step_length", ("limits", "step_length"), "0.5"),
    ("limits.jump", ("limits", "jump"), 0.5),
    ("limits.step_width_max", ("limits", "step_width_max"), DELETE),
    ("limits.step_width_min", ("limits", "step_width_min"), 0.5),
    ("limits.com_height_min", ("limits", "com_height_min"), 0.68),
    ("contact", ("contact",), "sole"),
    ("contact", ("contact",), "point"),
    ("contact", ("contact",), 2),
    ("contact_margin", ("contact_margin",), -0.001),
    ("contact_margin", ("contact_margin",), "0"),
    ("contact_margin", ("contact_margin",), 0.0751),  # half the length
    ("feet[0].contact_width", ("contact",), "surface"),
    ("feet[1].contact_width", ("feet", 1, "contact_width"), 0.05),
    ("feet[0].contact_width", ("feet", 0, "contact_width"), 0.0),
]


@pytest.mark.parametrize(("entry", "path", "value"), WRONG, ids=range(len(WRONG)))
def test_wrong_entries_are_named(folder, entry, path, value):
    refused(folder, changed(path, value), entry)


def with_soles(width=0.04, **more):
    """Return the shipped description with feet that have a width."""
    data = copy.deepcopy(DATA) | {"contact": "surface"} | more
    for foot in data["feet"]:
        foot["contact_width"] = width
    return data


def test_a_point_is_refused_with_the_reason(folder):
    assert (
        "cannot stand still" in refused(folder, changed(("contact",), "point"), "contact").allowed
    )


def test_a_margin_leaves_something_of_the_sole(folder):
    refused(folder, with_soles(0.04, contact_margin=0.02), "contact_margin")
    uneven = with_soles()
    uneven["feet"][1]["contact_width"] = 0.041
    refused(folder, uneven, "feet[1].contact_width")


@pytest.mark.parametrize("margin", [0.0, 0.004])
def test_the_contact_is_that_of_the_description(folder, margin):
    file = folder / "soles.yaml"
    file.write_text(yaml.safe_dump(with_soles(0.04, contact_margin=margin)), encoding="utf-8")
    robot = Humanoid(load_description(file), checked=False)  # its legs have no ankle roll
    assert isinstance(robot.contact, SurfaceContact)
    halves = [robot.half_length, robot.half_width]
    within = [robot.contact.half_length, robot.contact.half_width]
    np.testing.assert_allclose([halves, within], [[0.075, 0.02], [0.075 - margin, 0.02 - margin]])
    assert robot.sizes["nw"] == 6
    corners = [[-0.05, 0.02], [-0.05, -0.02], [0.1, 0.02], [0.1, -0.02]]
    np.testing.assert_allclose(robot.contact_points[..., :2], [corners, corners], atol=1e-15)
    np.testing.assert_array_equal(robot.contact_points[..., 2], -0.041)
    np.testing.assert_allclose(robot.contact_points.mean(axis=1), robot.p_FC, atol=1e-15)
    file.write_text(yaml.safe_dump(DATA | {"contact_margin": margin}), encoding="utf-8")
    line = load_humanoid(file)
    assert line.contact == LineContact(line.half_length - margin)
    assert (line.half_width, line.sizes["nw"]) == (0.0, 5)
    np.testing.assert_array_equal(line.contact_points[0], line.description.feet[0].contact_points)


# --- entries that do not fit the model -------------------------------------------------------

MISFITS = [
    ("floating_base", ("floating_base",), "trunk"),
    ("floating_base", ("floating_base",), "left_foot_link"),
    ("feet[1].frame", ("feet", 1, "frame"), "right_toe_link"),
    ("feet[1].contact_points", ("feet", 1, "contact_points"), [[-0.05, 0, 0], [0.2, 0, 0]]),
    ("feet[0].leg_joints", ("feet", 0, "leg_joints"), [*LEG[:-1], "left_toe"]),
    ("arm_joints", ("arm_joints",), DATA["arm_joints"][:-1]),
    ("arm_joints", ("arm_joints",), [*DATA["arm_joints"], LEG[0]]),
    ("arm_joints", ("arm_joints",), ["tail", *DATA["arm_joints"]]),
    ("nominal_posture.left_knee", ("nominal_posture", "left_knee"), -0.1),
    ("nominal_posture.right_ankle", ("nominal_posture", "right_ankle"), 0.9),
    ("model", ("model",), "nothing.urdf"),
    ("model", ("model",), "parameters.yaml"),
]


@pytest.mark.parametrize(("entry", "path", "value"), MISFITS, ids=range(len(MISFITS)))
def test_entries_that_do_not_fit_the_model_are_named(folder, entry, path, value):
    refused(folder, changed(path, value), entry)


def without(data, *joints):
    """Return a description that does not know some joints."""
    data = copy.deepcopy(data)
    data["actuated_joints"] = [j for j in data["actuated_joints"] if j not in joints]
    data["mirror"] = {k: v for k, v in data["mirror"].items() if k not in joints}
    data["nominal_posture"] = {k: v for k, v in data["nominal_posture"].items() if k not in joints}
    for foot in data["feet"]:
        foot["leg_joints"] = [j for j in foot["leg_joints"] if j not in joints]
    return data


def test_fewer_names_than_actuators(folder):
    error = refused(folder, without(DATA, "left_knee", "right_knee"), "actuated_joints")
    assert "16 names" in str(error)
    assert "18 actuators" in str(error)


def test_joints_in_another_order_than_the_actuators(folder):
    data = changed(("actuated_joints",), [JOINTS[1], JOINTS[0], *JOINTS[2:]])
    assert "left_hip_yaw" in refused(folder, data, "actuated_joints[0]").allowed


def test_a_joint_the_model_does_not_have(folder):
    text = yaml.safe_dump(DATA, sort_keys=False).replace("right_elbow", "right_wrist")
    refused(folder, text, "actuated_joints[17]")


def test_legs_of_different_length(folder):
    data = copy.deepcopy(DATA)
    data["arm_joints"].append(data["feet"][1]["leg_joints"].pop())
    refused(folder, data, "feet[1].leg_joints")


@pytest.mark.parametrize(
    ("old", "new", "joint"),
    [
        ('velocity="30" effort="55"', 'effort="55"', "left_elbow"),
        ('velocity="20" effort="144"', 'velocity="20"', "left_knee"),
        ('lower="-0.8" upper="0.8" ', "", "left_ankle"),
    ],
)
def test_a_model_without_limits(folder, old, new, joint):
    urdf = (folder / DATA["model"]).read_text(encoding="utf-8")
    assert old in urdf
    (folder / "changed.urdf").write_text(urdf.replace(old, new), encoding="utf-8")
    error = refused(folder, changed(("model",), "changed.urdf"), "model")
    assert error.value == joint
    assert "no finite" in error.allowed


def test_a_model_that_is_no_model(folder):
    (folder / "broken.urdf").write_text("<robot name='x'><link", encoding="utf-8")
    refused(folder, changed(("model",), "broken.urdf"), "model")


# --- files ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "text",
    [
        "name: [unclosed",
        "a: b: c",
        "\t- x",
        "name: 2020-99-99",
        "name: \x00",
        "!!python/object:os.system x",
        "'" + "x" * 10,
    ],
)
def test_files_that_are_no_yaml(folder, text):
    found = refused(folder, text, ...)
    assert "YAML" in found.allowed
    assert found.entry in ("", "line 1")


@pytest.mark.parametrize("text", ["", "just text", "[1, 2]", "7"])
def test_files_that_are_no_description(folder, text):
    assert "must be a dictionary" in refused(folder, text, "").allowed


def test_a_file_that_is_not_text(folder):
    file = folder / "binary.yaml"
    file.write_bytes(b"\xff\xfe\x80")
    with pytest.raises(ModelError, match="YAML"):
        load_humanoid(file)


def test_missing_files_and_unknown_names(tmp_path):
    for name in (tmp_path / "nothing.yaml", tmp_path / "none" / "nothing.yml"):
        with pytest.raises(ModelError, match="cannot be read") as caught:
            load_humanoid(name)
        assert caught.value.where == str(name)
        assert "\n" not in str(caught.value)
    for name in ("mit_humanoidd", "", "scenes"):
        with pytest.raises(ModelError, match="none of \\['mit_humanoid'\\]") as caught:
            load_humanoid(name)
        assert str(caught.value).startswith(f"robot = {name!r}")
        assert "\n" not in str(caught.value)
    with pytest.raises(ModelError, match="must be a folder with one description"):
        load_humanoid("..")


def test_an_empty_folder_is_no_robot(tmp_path):
    (tmp_path / "folder.yaml").mkdir()
    with pytest.raises(ModelError, match="must be a folder with one description"):
        load_humanoid(tmp_path / "folder.yaml")
