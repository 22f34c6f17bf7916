"""The zoo: made-up robots walk, on lines and soles, those with point feet do not; what is said."""

import json

import numpy as np
import pytest
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from drake_linefoot.lab.new_robot.analysis import analyse
from drake_linefoot.robot.scaling import COM_HEIGHT, MASS
from studies.common.command import run
from studies.zoo import made_up
from studies.zoo.__main__ import FOUND, found_before, summary_of, zoo
from studies.zoo.disturbed import impulse
from studies.zoo.page import HEAD, bars, row_of
from studies.zoo.robots import G1, HEAVY, MADE_UP, PACKAGE, QUICK, SMALL, make, published
from studies.zoo.trials import SKILLS


@pytest.mark.slow
def test_a_quick_look_walks_made_up_robots_and_refuses_point_feet(tmp_path, capsys):
    assert run(zoo, "zoo", ["--quick", "--out", str(tmp_path)]) == 0
    assert "of 6: point_feet as a surface" in capsys.readouterr().out
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert list(summary["robots"]) == list(QUICK)
    assert (summary["quick"], summary["seeds"], summary["missing"]) == (True, [0], [])
    for found in summary["robots"].pop("point_feet").values():
        assert "the foot is a point" in found["refused"]
    page = (tmp_path / "index.md").read_text()
    assert "joints, a sole needs six" in summary["robots"]["no_arms"].pop("surface")["refused"]
    walks = [(name, *each) for name, robot in summary["robots"].items() for each in robot.items()]
    for name, contact, found in walks:
        assert found["skills"] == dict.fromkeys(SKILLS, 1), found["falls"]
        assert found["fastest"]["share"] == pytest.approx(0.1, abs=0.02)
        assert found["pushed"].keys() == {"0"} and abs(found["side_drift"]) < 0.1
        assert found["picture"] in page
        assert (tmp_path / found["picture"]).read_bytes().startswith(b"\x89PNG")
        rolls = [f"{side}_ankle_roll" for side in made_up.SIDES]
        locked = rolls if (name, contact) == ("soled_60", "line") else []
        assert (found["refused"], sorted(found["locked"])) == (None, locked), name
    assert len({found["picture"] for *_, found in walks}) == len(walks) == 3
    assert [summary["bars"][key]["met"] for key in ("all_skills", "as_fast", "g1")] == [
        *(True, True, None)
    ]


def walked(share, speed, lacking=0):
    skills = {**dict.fromkeys(SKILLS, 3), "turn": 3 - lacking}
    fastest = {"share": share, "speed": speed, "stopped_by": "slips"}
    return {"refused": None, "mass": 2.0, "com_height": 0.2, "locked": ["a"], "skills": skills,
            "fastest": fastest, "pushed": {"0": True, "180": not lacking},
            "side_drift": -0.02}  # fmt: skip


REFUSED = {"refused": "short"}


def both(line, surface=REFUSED):
    return {"line": line, "surface": surface}


def test_what_is_asked_is_of_those_that_are_not_refused():
    robots = {
        HEAVY: both(walked(0.5, 1.21)),
        SMALL: both(walked(0.32, 0.19)),
        "bolt": both(REFUSED),
        G1: both(walked(0.41, 1.05), walked(0.4, 1.1)),
    }
    found = bars(robots, 3)
    asked = (
        *("commands", "lines_typed", "all_skills", "mean_share", "as_fast", "g1", "heavy"),
        *("pushed", "side_drift"),
    )
    assert {key: bar["met"] for key, bar in found.items()} == {
        **dict.fromkeys(asked, True),
        "small": False,
    }
    assert found["mean_share"]["value"] == pytest.approx(0.41)
    assert (found["all_skills"]["bar"], found["as_fast"]["bar"]) == (4, 1)
    assert (found["pushed"]["value"], found["side_drift"]["value"]) == (1, 0.02)
    slower = both(walked(0.4, 0.3), walked(0.37, 0.3, lacking=1))
    lacking = bars({**robots, "other": slower}, 3)
    assert judged(lacking["all_skills"]) == (5, 6, False)
    assert judged(lacking["as_fast"]) == judged(lacking["pushed"]) == (1, 2, False)
    robots["other"] = both(REFUSED, {**walked(0.4, 0.3), "side_drift": None})
    assert judged(bars(robots, 3)["side_drift"]) == (None, 0.03, False)
    unable = bars({"other": slower}, 4)
    assert judged(unable["commands"]) == (None, 2, False)
    assert judged(unable["lines_typed"]) == (None, 0, False)
    nothing = bars({}, 3)
    assert {key for key, bar in nothing.items() if bar["met"] is not None} == set()


def judged(bar):
    return bar["value"], bar["bar"], bar["met"]


def test_pushes_are_an_ellipse(humanoid):
    """Its axes are ahead and aside; what lies between is of both, by its equation."""
    unit = humanoid.mass * np.sqrt(9.81 * humanoid.com_height)
    x, y = (impulse(humanoid, angle) / unit for angle in (np.pi, 0.5 * np.pi))
    assert (x, y) == pytest.approx((0.24, 0.14), rel=1e-3)
    between = impulse(humanoid, 0.5) / unit * np.array([np.cos(0.5), np.sin(0.5)])
    assert np.sum((between / (x, y)) ** 2) == pytest.approx(1.0)


def test_a_run_goes_on_with_what_the_same_version_found(tmp_path):
    about, file = (
        {"made_with": {"lab": "1"}, "quick": False, "package": "p", "seeds": [0]},
        tmp_path / "s",
    )
    found = {"a": both(walked(0.4, 1.0)), "b": {"line": REFUSED}}
    file.write_text(json.dumps(summary_of(about, ["a", "b", "c"], found, 7)))
    summary = json.loads(file.read_text())
    assert (summary["missing"], list(summary["robots"])) == (["b", "c"], ["a"])
    before = found_before(file, about)
    assert (before[FOUND], before["seconds"]) == (found, 7)
    for other in ({"made_with": {"lab": "2"}}, {"seeds": [0, 1]}):
        assert found_before(file, {**about, **other}) == {}
    assert found_before(tmp_path / "none", about) == {}


def test_a_row_has_lines_beside_surfaces():
    row = dict(zip(HEAD, row_of("x", both(walked(0.4, 1.0), walked(0.5, 1.25, 1))), strict=True))
    assert (row["skills: line"], row["skills: surface"]) == ("all 3", "3 3 3 2 3 3")
    assert (row["m/s: line"], row["m/s: surface"]) == ("1.00", "1.25")
    assert (row["share: line"], row["share: surface"]) == ("0.40", "0.50")
    assert (row["pushes: line"], row["pushes: surface"]) == ("2 of 2", "1 of 2")
    assert row["drift: line"] == "-0.020"
    fell = {**walked(0.4, 1.0), "side_drift": None}
    assert row_of("x", both(fell))[HEAD.index("drift: line")] == "fell"
    assert row_of("bolt", both(REFUSED)) == ["bolt", "-", *["refused"] * 2, *["-"] * 8]
    assert row_of("x", both(walked(0.4, 1.0)))[1:4] == ["2.0", "all 3", "-"]


def test_like_an_h1_2_and_60_kg_are_soled(tmp_path):
    """Described as surfaces by themselves, with masses and soles as they are said to have."""
    for name, mass, half_width in (("like_h1_2", 68.0, 0.045), ("soled_60", 60.0, 0.025)):
        humanoid = analyse(make(name, tmp_path)).humanoid
        assert humanoid.mass == pytest.approx(mass)
        assert (humanoid.contact.size, humanoid.half_width) == (6, pytest.approx(half_width))


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
