"""`linefoot new-robot`: what it writes and prints, and what it refuses, in one line each."""

import re
import xml.etree.ElementTree as ET
from functools import partial

import pytest
import yaml

from drake_linefoot.lab import cli
from drake_linefoot.lab.scenario.load import load_scenario
from drake_linefoot.robot.humanoid import load_humanoid
from tests.helpers import made_up_robots as made_up
from tests.helpers.command_line import refuse


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty folder to work in."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def robot(folder, capsys):
    """What the command writes of a robot with box feet and ankle rolls."""
    tree = made_up.mit()
    made_up.box_feet(tree)
    made_up.add_roll(tree)
    made_up.write(tree, folder, "biped")
    assert cli.main(["new-robot", "biped.urdf"]) == 0
    return folder / "biped", capsys.readouterr()


def test_it_writes_a_description_and_a_walk(robot):
    written, (out, err) = robot
    assert err == ""
    found = sorted(path.name for path in written.iterdir())
    assert found == ["biped.yaml", "robot.png", "walk.yaml"]
    assert "joints locked" not in out
    assert "soles, from collision shapes: 0.200 m long, 0.060 m wide" in out
    said = "contact: a surface 0.200 m long, 0.060 m wide, the largest rectangle in the sole"
    assert f"{said}; its cones leave 4.5 mm at each edge" in out
    assert re.search(r"left_knee holds [\d.]+ of 144 N m \(\d+%\)", out)
    assert out.splitlines()[-1] == "biped: now linefoot walk --robot biped"
    assert all(len(line) < 300 for line in out.splitlines())
    humanoid = load_humanoid(written / "biped.yaml")
    d = humanoid.description
    assert (d.lock, d.contact, d.contact_margin) == ({}, "surface", 0.0045)
    assert [foot.contact_width for foot in d.feet] == [0.06, 0.06]
    assert humanoid.half_length == pytest.approx(0.1, abs=1e-5)


def test_a_line_is_given_on_demand_and_locks_the_ankle_roll(robot, capsys):
    assert cli.main(["new-robot", "biped.urdf", "--out", "line", "--contact", "line"]) == 0
    out = capsys.readouterr().out
    assert "2 joints locked: left_ankle_roll, right_ankle_roll" in out
    assert "contact: a line, with no ankle roll: asked for" in out
    d = load_humanoid("line/biped.yaml").description
    assert d.lock == {"left_ankle_roll": 0.0, "right_ankle_roll": 0.0}
    assert (d.contact, d.contact_margin, d.feet[0].contact_width) == ("line", 0.0, None)


def test_what_may_be_edited_stands_first(robot):
    text = (robot[0] / "biped.yaml").read_text()
    assert list(yaml.safe_load(text))[1:5] == [
        *("lock", "nominal_posture", "limits", "contact_margin")
    ]
    assert "contact_margin" in text[: text.index("name:")]


def test_its_walk_is_a_scenario_of_ten_seconds_for_that_robot(robot):
    written, _ = robot
    scenario = load_scenario(written / "walk.yaml")
    assert scenario.duration == pytest.approx(10.0)
    assert [segment.walk for segment in scenario.segments] == [False, True, False]
    height = scenario.gait.com_height
    assert scenario.segments[1].velocity[0] == pytest.approx(0.3 * (height / 0.65) ** 0.5, abs=0.01)
    data = yaml.safe_load((written / "biped.yaml").read_text())
    assert list(data)[:4] == ["name", "lock", "nominal_posture", "limits"]


def test_what_exists_is_left_as_it_is(robot, capsys):
    written, _ = robot
    before = {path: path.read_bytes() for path in written.iterdir()}
    assert "biped: cannot be written: exists already" in refuse(capsys, "new-robot", "biped.urdf")
    assert {path: path.read_bytes() for path in written.iterdir()} == before


def test_arms_are_locked_on_demand(folder, capsys):
    made_up.write(made_up.mit(), folder, "biped")
    assert cli.main(["new-robot", "biped.urdf", "--out", "a/b", "--lock-arms"]) == 0
    humanoid = load_humanoid(folder / "a" / "b" / "biped.yaml")
    assert (humanoid.na, len(humanoid.arm_v)) == (10, 0)
    assert "8 joints locked" in capsys.readouterr().out


@pytest.mark.parametrize("command", ["walk", "drive", "show"])
def test_commands_refuse_a_folder_that_holds_no_robot(folder, capsys, command):
    assert "is no folder that is there" in refuse(capsys, command, "--robot", "nowhere")
    (folder / "empty").mkdir()
    assert "one description" in refuse(capsys, command, "--robot", "empty")


def test_show_says_what_was_done_to_a_robot(robot, capsys):
    assert cli.main(["show", "--robot", "biped", "--loop-once"]) == 0
    out = capsys.readouterr().out
    assert "2 actuators made" in out and "spheres" in out


def test_walk_takes_the_folders_own_scenario_and_a_robot_for_another(robot, capsys):
    """Both are refused for their `--out`, after robot and scenario have been read."""
    (robot[0].parent / "full").mkdir()
    (robot[0].parent / "full" / "mine").write_text("")
    for words in ((), ("stand",)):
        status = cli.main(["walk", *words, "--robot", "biped", "--out", "full/mine"])
        out, err = capsys.readouterr()
        assert status == 2 and "full/mine" in err
        assert "biped: 2 actuators made" in out


# --- what is refused ------------------------------------------------------------------------------


def change(pattern, new, count=1):
    def apply(text):
        changed, found = re.subn(pattern, new, text, count=count, flags=re.DOTALL)
        assert found
        return changed

    return apply


def edit(work):
    """Return a change of the text by a change of the tree."""

    def apply(text):
        tree = ET.ElementTree(ET.fromstring(text))
        work(tree)
        return ET.tostring(tree.getroot(), encoding="unicode")

    return apply


def joint(name, inner):
    return rf'(<joint name="{name}".*?{inner}=")[^"]*'


def weld(name):
    return change(rf'(<joint name="{name}" type=")revolute', r"\1fixed")


def short_feet(tree):
    made_up.box_feet(tree)
    for box in tree.iter("box"):
        box.set("size", "0.01 0.01 0.02")


def no_shapes(tree):
    for link in tree.getroot().findall("link"):
        for shape in [*link.findall("collision"), *link.findall("visual")]:
            link.remove(shape)


def longer_foot(tree):
    made_up.box_feet(tree)
    next(tree.iter("box")).set("size", "0.3 0.06 0.02")


def loop(tree):
    made_up.add_joint(tree, "loop", "left_foot_link", "torso", "0 0 1")


def other_robot(tree):
    made_up.add_link(tree, "stone", 1.0)


def to_the_world(tree):
    made_up.add_link(tree, "world", 1.0, first=True)
    made_up.add_joint(tree, "anchor", "world", "torso", "0 0 1", kind="fixed")


def limit_of(tree, name):
    return made_up.named(tree, "joint", name).find("limit")


def drop_effort(tree, name):
    made_up.drop_transmissions(tree)
    del limit_of(tree, name).attrib["effort"]


def endless_effort(tree, name):
    made_up.drop_transmissions(tree)
    limit_of(tree, name).set("effort", "inf")


def no_efforts(tree):
    """As CAD exporters write it."""
    made_up.drop_transmissions(tree)
    for limit in tree.iter("limit"):
        limit.attrib.update(effort="0", velocity="0")


def lost_sign(tree):
    made_up.bound(tree, "ankle", -1.0, 0.4)
    made_up.bound(tree, "ankle", -0.4, 1.0, ["right"])


def half_a_range(tree):
    made_up.bound(tree, "hip_pitch", -0.3, 1.5)
    made_up.bound(tree, "hip_pitch", -1.6, 0.25, ["right"])


def bare_foot(tree):
    """Nor has a motor's rotor any inertia."""
    made_up.drop_transmissions(tree)
    foot = made_up.named(tree, "link", "right_foot_link")
    foot.remove(foot.find("inertial"))


BAD = {
    "limits reversed": (
        change(joint("left_knee", "lower"), r"\g<1>9"),
        "left_knee: limits are rev",
    ),
    "no number": (change(joint("left_knee", "lower"), r"\g<1>x"), "lower is 'x'"),
    "nan limit": (
        change(joint("left_knee", "upper"), r"\g<1>nan"),
        "left_knee: limit upper is 'nan'",
    ),
    "nan mass": (change(r'(<mass value=")[^"]*', r"\1nan"), "torso: mass value is 'nan'"),
    "negative mass": (change(r'(<mass value=")[^"]*', r"\1-3"), "must not be negative"),
    "no inertia at all": (change(r"(?s)<inertial>.*?</inertial>", "", 0), "no link has a mass"),
    "a foot without inertia": (
        edit(bare_foot),
        "'right_foot_link': moves and has no mass, nor has what it carries: its inertia is missing",
    ),
    "entities": (
        lambda text: f'<!DOCTYPE r [<!ENTITY a "{"x" * 1000}">]>' + text[text.index("<robot") :],
        "it declares entities",
    ),
    "thousands of attributes": (
        change("<robot", "<robot" + "".join(f' a{i}="1"' for i in range(20_000))),
        "an element has 20001 attributes",
    ),
    "thousands of links": (
        change("</robot>", "".join(f'<link name="l{i}"/>' for i in range(3000)) + "</robot>"),
        "elements called link",
    ),
    "infinite inertia": (change(r'(ixx=")[^"]*', r"\1inf"), "torso: inertia ixx is 'inf'"),
    "two numbers of three": (change(r'(<origin xyz=")[^"]*', r"\g<1>1 2"), "Drake refuses it"),
    "an odd rpy": (change(r'(rpy=")[^"]*', r"\g<1>1 2"), "Drake refuses it: Expected 3 values"),
    "empty": (lambda text: "", "is no XML"),
    "cut off": (lambda text: text[: len(text) // 2], "is no XML"),
    "no robot": (lambda text: "<a/>", "Drake refuses it"),
    "no effort": (change(joint("left_knee", "effort"), r"\g<1>0"), "left_knee"),
    "no effort limit at all": (
        edit(lambda tree: drop_effort(tree, "left_knee")),
        "'left_knee': joint of a leg has no effort limit",
    ),
    "efforts of 0": (
        edit(no_efforts),
        "'left_hip_yaw': joint of a leg has no effort limit above 0",
    ),
    "endless effort": (
        edit(lambda tree: endless_effort(tree, "left_knee")),
        "left_knee: limit effort is 'inf', which must be a finite number",
    ),
    "no speed": (change(joint("left_knee", "velocity"), r"\g<1>0"), "left_knee': velocity limit"),
    "a knee the other way": (
        edit(lambda tree: made_up.bound(tree, "knee", -2.2, 0.0, ["right"])),
        "left_knee and right_knee': limits are no mirror images: [0, 2.2] and [-2.2, 0]",
    ),
    "an ankle with a lost sign": (
        edit(lost_sign),
        "left_ankle and right_ankle': limits are no mirror images: [-1, 0.4] and [-0.4, 1]",
    ),
    "a hip with little in common": (
        edit(half_a_range),
        "left_hip_pitch and right_hip_pitch': limits are no mirror images",
    ),
    "a little effort": (change(joint("left_knee", "effort"), r"\g<1>3"), "left_knee needs 7.5 N m"),
    "four joints": (weld("left_hip_yaw"), "a leg has 4 joints"),
    "unequal legs": (
        lambda text: weld("left_hip_yaw")(edit(made_up.add_roll)(text)),
        "both legs must have as many joints",
    ),
    "a slider": (change(r'(<joint name="left_knee" type=")revolute', r"\1prismatic"), "revolute"),
    "an unknown joint": (change(r'(<joint name="left_knee" type=")revolute', r"\1odd"), "odd"),
    "a child that is not there": (change('child link="left_shank_link"', 'child link="x"'), "x"),
    "a name twice": (change('joint name="left_knee"', 'joint name="left_ankle"'), "left_ankle"),
    "point feet": (edit(short_feet), "its sole is 10 mm long; on points a robot cannot stand"),
    "feet of one ball": (
        edit(partial(made_up.put_soles, heel=0.0, toe=0.0)),
        "the foot is a point: its sole is 0 mm long",
    ),
    "no shapes": (edit(no_shapes), "neither collision shapes nor meshes"),
    "unequal feet": (edit(longer_foot), "feet differ in length"),
    "a loop": (edit(loop), ""),
    "two robots": (edit(other_robot), "must have one body that floats"),
    "welded to the world": (edit(to_the_world), "must have one body that floats"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_robots_are_refused_in_a_line(folder, capsys, name):
    alter, said = BAD[name]
    text = made_up.write(made_up.mit(), folder, "plain").read_text(encoding="utf-8")
    file = folder / "bad.urdf"
    file.write_text(alter(text), encoding="utf-8")
    line = refuse(capsys, "new-robot", "bad.urdf")
    assert line.startswith("linefoot: bad.urdf: ")
    assert said in line
    assert len(line) < 320 and "np." not in line
    assert sorted(path.name for path in folder.iterdir()) == ["bad.urdf", "plain.urdf"]


def test_bytes_that_are_no_robot_are_refused_in_a_line(folder, capsys):
    content = {
        "latin.urdf": "<robot name='\xe9'/>".encode("latin-1"),
        "binary.urdf": bytes(range(256)),
        "pointer.urdf": b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n",
        "pointer.sdf": b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n",
        "robot.odd": b"nothing",
        "robot.xml": b"<mujoco",
        "robot.sdf": b"<sdf version='1.7'/>",
    }
    for name, data in content.items():
        (folder / name).write_bytes(data)
        line = refuse(capsys, "new-robot", name)
        assert line.startswith(f"linefoot: {name}: model = ")
        assert len(line) < 320
        assert ("git lfs pull" in line) == name.startswith("pointer")
    assert "No such file" in refuse(capsys, "new-robot", "none.urdf")
    (folder / "dir.urdf").mkdir()
    assert "cannot be read" in refuse(capsys, "new-robot", "dir.urdf")
    assert sorted(path.name for path in folder.iterdir()) == sorted([*content, "dir.urdf"])


def test_a_mesh_that_git_lfs_has_not_fetched_is_named(folder, capsys):
    (folder / "foot.stl").write_bytes(b"version https://git-lfs.github.com/spec/v1\n")
    tree = made_up.mit()
    next(tree.iter("mesh")).set("filename", "foot.stl")
    made_up.write(tree, folder, "biped")
    line = refuse(capsys, "new-robot", "biped.urdf")
    assert "foot.stl is a pointer of git-lfs" in line


def test_limits_that_differ_a_little_are_taken_and_said(folder, capsys):
    """The robot keeps to what both legs can."""
    tree = made_up.mit()
    made_up.bound(tree, "ankle", -0.7, 0.8, ["right"])
    made_up.bound(tree, "elbow", -0.5, 1.0, ["left"])
    made_up.write(tree, folder, "biped")
    assert cli.main(["new-robot", "biped.urdf"]) == 0
    out = capsys.readouterr().out
    for name, both in (("ankle", "[-0.8, 0.8] and [-0.7, 0.8]"), ("elbow", "[-0.5, 1] and")):
        assert f"left_{name} and right_{name}: limits are no mirror images: {both}" in out
    assert load_humanoid(folder / "biped" / "biped.yaml").description.limits.com_height_min > 0.58


def test_feet_that_differ_by_micrometres_are_equally_long(folder):
    tree = made_up.mit()
    made_up.box_feet(tree)
    for side, ahead in (("left", 0.03), ("right", 0.030004)):
        shape = made_up.named(tree, "link", f"{side}_foot_link").find("collision")
        made_up.put(shape.find("origin"), "xyz", [ahead, 0.0, -0.05])
        made_up.put(shape.find("geometry/box"), "size", [0.147535, 0.06, 0.02])
    made_up.write(tree, folder, "biped")
    assert cli.main(["new-robot", "biped.urdf"]) == 0
    humanoid = load_humanoid(folder / "biped" / "biped.yaml")
    assert humanoid.half_length == pytest.approx(0.5 * 0.147535, abs=5e-6)


def test_a_link_without_mass_that_carries_the_robot_is_left_out(folder, capsys):
    tree = made_up.mit()
    tree.getroot().append(ET.Element("link", name="map"))
    made_up.add_joint(tree, "where", "map", "torso", "0 0 1", kind="floating")
    made_up.write(tree, folder, "biped")
    assert cli.main(["new-robot", "biped.urdf"]) == 0
    assert "carries the robot left out: map" in capsys.readouterr().out
    assert load_humanoid(folder / "biped" / "biped.yaml").description.floating_base == "torso"


def test_a_colour_beyond_1_does_not_matter(folder, capsys):
    tree = made_up.mit()
    visual = next(tree.iter("visual"))
    for material in visual.findall("material"):
        visual.remove(material)
    visual.append(ET.fromstring('<material name="red"><color rgba="255 0 0 1"/></material>'))
    made_up.write(tree, folder, "biped")
    assert cli.main(["new-robot", "biped.urdf"]) == 0
    assert "1 drawings: colour not from 0 to 1, left out" in capsys.readouterr().out
