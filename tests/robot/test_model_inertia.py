"""Inertias that no body can have: a line by link, whatever the format."""

import numpy as np
import pytest
from pydrake.multibody.tree import RotationalInertia

from drake_linefoot.errors import ModelError
from drake_linefoot.robot.model_file import read_model_file
from tests.helpers import made_up_robots as made_up
from tests.robot.test_loading import load

SDF = """<sdf version="1.9"><model name="a"><link name="trunk"><inertial><mass>8</mass>
<inertia>{}</inertia></inertial></link></model></sdf>"""
MJCF = """<mujoco><worldbody><body name="trunk"><inertial pos="0 0 0" mass="8" {}/><freejoint/>
</body></worldbody></mujoco>"""


def notes_with(tmp_path, **moments):
    """What is said of a robot whose left shank has other moments of inertia."""
    tree = made_up.mit()
    inertia = made_up.named(tree, "link", "left_shank_link").find("inertial/inertia")
    inertia.attrib.update(moments)
    return load(tmp_path, tree).notes


@pytest.mark.parametrize(
    ("ixx", "said"),
    [("5.0", "the largest of 0.0002"), ("-5.0", "a moment of -5, 0.0002")],
)
def test_a_note_names_the_link_and_its_moments_and_drake_says_no_more(tmp_path, ixx, said):
    notes = [note for note in notes_with(tmp_path, ixx=ixx) if "meshes" not in note]
    (line,) = notes
    assert line.startswith(f"left_shank_link: its inertia is that of no body: {said}")
    assert line.endswith("taken as that of a ball of water of its mass")


def notes_of(folder, text, suffix):
    file = folder / f"model.{suffix}"
    file.write_text(text, encoding="utf-8")
    return read_model_file(file, file).notes


def test_they_are_those_that_drake_refuses(tmp_path):
    found = []
    for seed in range(200):
        rng = np.random.default_rng(seed)
        numbers = [*map(float, [*rng.uniform(0.0, 1.0, 3), *rng.uniform(-0.1, 0.1, 3)])]
        sides = zip(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), numbers, strict=True)
        inertia = "".join(f"<{side}>{number!r}</{side}>" for side, number in sides)
        refused = not RotationalInertia(*numbers).CouldBePhysicallyValid()
        assert len(notes_of(tmp_path, SDF.format(inertia), "sdf")) == refused, numbers
        found.append(refused)
    assert 50 < sum(found) < 150


@pytest.mark.parametrize(
    "inertia", ['diaginertia="5 0.1 0.1"', 'fullinertia="0.1 0.1 0.1 0.3 0 0"']
)
def test_mjcf_is_refused_by_body_as_drake_does(tmp_path, inertia):
    with pytest.raises(ModelError, match="trunk: its inertia is that of no body: ") as caught:
        notes_of(tmp_path, MJCF.format(inertia), "xml")
    assert "\n" not in str(caught.value)
    assert notes_of(tmp_path, MJCF.format('diaginertia="0.1 0.1 0.1"'), "xml") == (
        "MJCF has no limits of speed: 20 rad/s taken",
    )
