"""The zoo: robots made from a URDF walk, those with point feet do not, and what is said of it."""

import json

import numpy as np
import pytest
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from drake_linefoot.robot.scaling import COM_HEIGHT, MASS
from studies.common.command import run
from studies.zoo import made_up
from studies.zoo.__main__ import zoo
from studies.zoo.page import bars, row_of
from studies.zoo.robots import HEAVY, MADE_UP, PACKAGE, QUICK, SMALL, make, published
from studies.zoo.trials import SKILLS


@pytest.mark.slow
def test_a_quick_look_walks_made_up_robots_and_refuses_point_feet(tmp_path, capsys):
    assert run(zoo, "zoo", ["--quick", "--out", str(tmp_path)]) == 0
    assert "3 of 3" in capsys.readouterr().out
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert list(summary["robots"]) == list(QUICK)
    assert (summary["quick"], summary["seeds"], summary["missing"]) == (True, [0], [])
    assert "the foot is a point" in summary["robots"].pop("point_feet")["refused"]
    page = (tmp_path / "index.md").read_text()
    for name, robot in summary["robots"].items():
        assert robot["skills"] == dict.fromkeys(SKILLS, 1), robot["falls"]
        assert robot["fastest"]["share"] == pytest.approx(0.1, abs=0.02)
        assert robot["picture"] in page
        assert (tmp_path / robot["picture"]).read_bytes().startswith(b"\x89PNG")
        assert (robot["refused"], robot["locked"]) == (None, []), name
    assert [summary["bars"][key]["holds"] for key in ("all_skills", "mean_share", "small")] == [
        *(True, False, None)
    ]


def walked(share, speed, lacking=0):
    skills = {**dict.fromkeys(SKILLS, 3), "turn": 3 - lacking}
    fastest = {"share": share, "speed": speed, "stopped_by": "slips"}
    return {"refused": None, "mass": 2.0, "com_height": 0.2, "locked": ["a"], "skills": skills,
            "fastest": fastest}  # fmt: skip


def test_what_is_asked_is_of_those_that_are_not_refused():
    robots = {HEAVY: walked(0.5, 1.21), SMALL: walked(0.32, 0.19), "bolt": {"refused": "short"}}
    found = bars(robots, 3)
    assert {key: bar["holds"] for key, bar in found.items()} == {
        **dict.fromkeys(("commands", "lines_typed", "all_skills", "mean_share", "heavy"), True),
        "small": False,
    }
    assert found["mean_share"]["value"] == pytest.approx(0.41)
    lacking = bars({**robots, "other": walked(0.1, 0.3, lacking=1)}, 3)["all_skills"]
    assert lacking == {"value": 2, "bar": 3, "holds": False}
    assert row_of("bolt", robots["bolt"])[-1] == "refused: short"
    assert row_of(SMALL, robots[SMALL])[3:5] == ["1", "3 3 3 3 3 3"]


@pytest.fixture
def changed(tmp_path):
    """Parse a made-up robot; return its plant."""

    def parse(name):
        plant = MultibodyPlant(0.0)
        Parser(plant).AddModels(str(make(name, tmp_path)))
        plant.Finalize()
        return plant

    return parse


def test_a_robot_of_another_size_is_similar(changed, humanoid):
    """Mass matrix and effort limits are those of the shipped robot, in its units."""
    plant = changed(SMALL)
    length, mass = 0.22 / COM_HEIGHT, 2.0 / MASS
    context = plant.CreateDefaultContext()
    assert plant.CalcTotalMass(context) == pytest.approx(2.0)
    shipped = humanoid.plant
    unit = np.array([*[length] * 3, *[1.0] * 3, *[length] * (plant.num_velocities() - 6)])
    old = shipped.CreateDefaultContext()
    M = mass * np.outer(unit, unit) * shipped.CalcMassMatrix(old)
    np.testing.assert_allclose(plant.CalcMassMatrix(context), M, atol=1e-12)
    limits, own = (
        np.array([p.get_joint_actuator(i).effort_limit() for i in p.GetJointActuatorIndices()])
        for p in (plant, shipped)
    )
    np.testing.assert_allclose(limits, mass * length * own)


def test_the_heavy_robot_has_weak_ankles(changed):
    plant = changed(HEAVY)
    assert plant.CalcTotalMass(plant.CreateDefaultContext()) == pytest.approx(59.0)
    for side in made_up.SIDES:
        assert plant.GetJointActuatorByName(f"{side}_ankle").effort_limit() == 40.0


def test_robots_of_others_are_where_they_are_looked_for():
    files, package = published()
    if not package:
        pytest.skip(f"{PACKAGE} is not installed")
    assert package == f"{PACKAGE} 6.0.0"
    assert [name for name, file in files.items() if not file.is_file()] == []
    assert not files.keys() & MADE_UP.keys()
