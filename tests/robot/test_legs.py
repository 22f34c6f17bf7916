"""Which joints of a leg bend it and turn its foot, and what a leg with a sole must be made of."""

import pytest
import yaml

from drake_linefoot.errors import ModelError
from drake_linefoot.lab.new_robot.analysis import analyse
from drake_linefoot.robot.description import load_description
from drake_linefoot.robot.humanoid import Humanoid, load_humanoid
from drake_linefoot.robot.legs import Roles, leg_roles
from studies.zoo.soled import BIPED, H1_2, write_soled

SOLE = (0.17, 0.06)  # [m]


def test_knee_and_ankle_are_found_by_their_axes(humanoid, small_biped, sole_biped):
    assert leg_roles(humanoid) == leg_roles(small_biped) == Roles(knee=3, ankle=4, roll=-1)
    assert leg_roles(sole_biped) == Roles(knee=3, ankle=4, roll=5)


@pytest.mark.parametrize("hips", [(0, 1, 2), (2, 0, 1), (1, 2, 0)])
def test_hips_and_ankles_of_other_orders(tmp_path, hips):
    """An ankle that rolls before it pitches; hips as those of other humanoids."""
    joints = BIPED.leg
    roll = joints[5]._replace(place=joints[4].place, length=joints[4].length)
    pitch = joints[4]._replace(place=joints[5].place, length=joints[5].length)
    first = [joints[k]._replace(place=joints[i].place) for i, k in enumerate(hips)]
    first = [
        joint._replace(length=joints[i].length, mass=joints[i].mass)
        for i, joint in enumerate(first)
    ]
    design = BIPED._replace(leg=(*first, joints[3], roll, pitch))
    found = analyse(write_soled(tmp_path, "other", design, SOLE)).humanoid
    assert found.contact.size == 6
    assert leg_roles(found) == Roles(knee=3, ankle=5, roll=4)


def test_a_hip_that_rolls_last_is_no_ankle(tmp_path):
    found = analyse(write_soled(tmp_path, "like_h1_2", H1_2, SOLE)).humanoid
    assert leg_roles(found) == Roles(knee=3, ankle=4, roll=5)


@pytest.fixture
def changed(tmp_path):
    """Describe the biped, change its leg and its description; return the latter's file."""

    def write(work=lambda data: None, **axes):
        data = analyse(write_soled(tmp_path, "plain", BIPED, SOLE)).data
        leg = tuple(j._replace(axis=axes.get(j.name, j.axis)) for j in BIPED.leg)
        model = write_soled(tmp_path, "changed", BIPED._replace(leg=leg), SOLE)
        data["model"] = str(model)
        work(data)
        file = tmp_path / "changed.yaml"
        file.write_text(yaml.safe_dump(data), encoding="utf-8")
        return file

    return write


def test_an_ankle_that_turns_about_another_axis_is_refused(changed):
    file = changed(ankle_roll="0 0 1")
    allowed = "the last two joints must pitch and roll the sole"
    with pytest.raises(ModelError, match=rf"feet\[0\]\.leg_joints = .*: {allowed}"):
        load_humanoid(file)
    with pytest.raises(ModelError, match="for a sole an ankle that turns about x"):
        leg_roles(Humanoid(load_description(file), checked=False))


def test_a_surface_with_five_joints_is_refused(changed):
    def five(data):
        for foot in data["feet"]:
            data["lock"][foot["leg_joints"].pop(0)] = 0.0

    with pytest.raises(ModelError, match="must name 6 joints: position of the sole and its pitch"):
        load_humanoid(changed(five))


def test_a_line_with_six_joints_is_refused(changed):
    def line(data):
        del data["contact"], data["contact_margin"]
        for foot in data["feet"]:
            del foot["contact_width"]

    with pytest.raises(ModelError, match="must name 5 joints: position of the line and its pitch"):
        load_humanoid(changed(line))
