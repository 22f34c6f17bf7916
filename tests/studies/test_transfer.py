"""The page of the same walks in two simulators: of known rows, and one run of each plant."""

from dataclasses import replace

import mujoco
import pytest

from drake_linefoot.lab.scenario.courses import TerrainParameters
from drake_linefoot.lab.scenario.load import dump_scenario, validate
from studies.common.paired import KNOWN, SIMULATORS, Draw, drawn, draws, lost, scenario, shares
from studies.transfer import cases as transfer
from studies.transfer import robots
from studies.transfer.cases import (
    CASES,
    DRAKE,
    ESTIMATE,
    LATE,
    LATE_PLANS,
    MUJOCO,
    MUJOCO_2,
    OWN,
    PLANTS,
)
from studies.transfer.page import BESIDE, TABLES, bars_of, page_of

TILTS = {"drake_tilt": 0.05, "mujoco_tilt": 0.0625}
ONE_LOST, TWO_WON = ({"mujoco_lost": lost, "mujoco_won": won} for lost, won in ((1, 0), (0, 2)))
PAIRS = {
    "wide": {"runs": 200, "drake": 200, "mujoco": 199, **TILTS, **ONE_LOST},
    "push": {"runs": 20, "drake": 10, "mujoco": 12, **TILTS, **TWO_WON},
}
LATE_ONES = {"push": {"runs": 20, "drake": 10, "late": 9, "drake_tilt": 0.05, "late_tilt": None}}
OWN_ONES = {"push": {"runs": 5, "drake": 4, "own": 3, "drake_tilt": 0.05, "own_tilt": 0.07}}
WAYS = tuple(dict.fromkeys(way for ways in BESIDE.values() for way in ways))

WALKS = [
    robots.missed(one, "") | {"contact": "line", "upright": one.name != "no_arms", "speed": 0.3}
    for one in robots.robots(False)
]
WALKS[0]["reason"] = "fell over"


def row(case, plant, **changes):
    numbers = {"speed_error": 0.01, "contact_latency": 1.0, "false_contacts": 0, "rate": 1.5}
    numbers |= {"missed_contacts": 0, "fall_reason": "", "tilt": 0.02, "force": 1.8}
    return {"case": case, "plant": plant, "upright": True, **numbers, **changes}


def rows_with(changes=None):
    changes = changes or {}
    return [row(c, p, **changes.get((c, p), {})) for c in CASES for p in PLANTS]


def bars_by_name(rows):
    return {key: (bar["value"], bar["met"]) for key, bar in bars_of(rows, PAIRS, WALKS).items()}


def test_bars_are_those_of_their_plants():
    rows = rows_with(
        {
            ("0.8 m/s", MUJOCO): {"speed_error": 0.04, "contact_latency": 6.0},
            ("1.2 m/s", OWN): {"speed_error": 0.045},
            ("1.2 m/s", DRAKE): {"speed_error": 0.5, "false_contacts": 3},
            (ESTIMATE, MUJOCO): {"speed_error": 0.06},
            (LATE, MUJOCO): {"speed_error": 0.05},
            **{(case, MUJOCO_2): {"rate": 4.5} for case in CASES},
        }
    )
    found = bars_by_name(rows)
    assert found["speed_error"] == (0.04, False)
    assert found["own_contacts"] == (0.045, True)
    assert found["on_estimate"] == (0.06, False)
    assert found["late_torques"] == (0.05, True)
    assert found["wide"] == (0.5, True)  # from -0.9 to 1.9 points
    assert found["push"] == (-10.0, None)  # 20 pairs are too few
    assert found["latency"] == (6.0, False)
    assert found["false_contacts"] == (0, True)
    assert found["rate"] == (pytest.approx(3.0), True)
    assert found["fell"] == (0, True)
    walking = len({one["name"] for one in WALKS}) - 1
    assert found["robots"] == (walking, walking >= 4)


def test_a_fall_is_counted_and_said():
    nothing = {"speed_error": None, "contact_latency": None, "rate": None}
    rows = rows_with({("0.4 m/s", OWN): {"upright": False, **nothing}})
    assert bars_by_name(rows)["fell"] == (1, False)
    bars = bars_of(rows, PAIRS, WALKS)
    page = page_of({"made_with": {"drake": "1"}, "bars": bars, "runs": rows, "pairs": PAIRS,
                    "own": OWN_ONES, "late": LATE_ONES, "robots": WALKS})  # fmt: skip
    assert "| push | 20 | 10, 0.050 | 12, 0.062 |\n\n## In MuJoCo's own contacts" in page
    assert "| push | 5 | 4, 0.050 | 3, 0.070 |\n\n## Late plans" in page
    assert "| push | 20 | 10, 0.050 | 9, - |\n\n## Robots" in page and "changed. drake 1." in page
    assert "| half_mass, line | drake | 0.30 | - | walks |" in page
    assert page.count("| fell ") == len(TABLES)
    assert "| `fell` | runs that are not upright | 1 | - | at most 0 | **NO** |" in page


def test_each_draw_is_made_in_both_simulators():
    some = list(draws(3, WAYS))
    assert len({one.key for one in some}) == len(some)
    rows = [
        lost(one, "died")
        | {"upright": one.index < 1 + (one.how == "drake"), "tilt": 0.1 * one.index}
        for one in some
    ]
    counts = {"runs": 3, "drake": 2} | dict.fromkeys(WAYS[1:], 1)
    counts |= {
        f"{how}_{what}": n
        for how in WAYS[1:]
        for what, n in (("lost", 1), ("won", 0), ("taken", 0))
    }
    tilts = {f"{how}_tilt": 0.1 for how in WAYS}
    assert all(one == counts | tilts for one in shares(rows).values())
    drawn_in = {how: {(one.group, one.index) for one in some if one.how == how} for how in WAYS}
    assert all(same == drawn_in["drake"] for same in drawn_in.values())


@pytest.mark.slow
def test_a_draw_is_simulated_where_it_says(monkeypatch):
    pytest.importorskip("mujoco", reason="MuJoCo is not installed: the extra mujoco")
    rows = [drawn(Draw("stand_push_10", 0, how)) for how in (*WAYS, KNOWN)]
    assert [row["how"] for row in rows] == [*WAYS, KNOWN]
    assert all(row["upright"] for row in rows)
    tilts = {row["how"]: row["tilt"] for row in rows}
    assert len({tilts[how] for how in WAYS}) == len(WAYS)
    assert tilts[KNOWN] == tilts[SIMULATORS[0]], "on level ground a map changes nothing"


def test_a_draw_may_have_a_map():
    found = {how: scenario(Draw("wide_rough", 0, how)) for how in ("drake", KNOWN)}
    assert found["drake"].terrain.source == "felt"
    assert found[KNOWN] == replace(found["drake"], terrain=TerrainParameters("scene"))


def test_cases_are_scenarios_and_a_lost_run_has_every_value():
    for case in CASES:
        for plant in PLANTS:
            scenario = transfer.scenario_of(case, plant, 3.0)
            validate(scenario)
            assert scenario.duration == pytest.approx(3.0)
            assert scenario.mpc.late is (plant == LATE_PLANS)
    assert set(transfer.lost(("a", "b", ""), "died")) == set(row("a", "b"))


@pytest.mark.slow
@pytest.mark.parametrize("plant", [MUJOCO, DRAKE])
def test_a_case_is_walked(plant):
    pytest.importorskip("mujoco", reason="MuJoCo is not installed: the extra mujoco")
    text = dump_scenario(transfer.scenario_of("0.4 m/s", plant, 2.5))
    found = transfer.walked(("0.4 m/s", plant, text))
    assert found["upright"] and found["rate"] > 0.0
    assert 1.0 < found["force"] < 4.0 and 0.0 < found["tilt"] < 0.1
    assert set(found) == set(row("a", "b"))


@pytest.mark.slow
def test_a_robot_of_the_zoo_walks_in_both_simulators():
    pytest.importorskip("mujoco", reason="MuJoCo is not installed: the extra mujoco")
    rows = [robots.walked(one) for one in robots.robots(True)]
    assert [row["simulator"] for row in rows] == list(SIMULATORS)
    assert robots.in_both(rows) == ["half_mass"], rows
    assert all(row["contact"] == "line" and row["error"] < 0.2 for row in rows)


def test_a_robot_that_is_published_for_mujoco_is_tried_as_it_is(monkeypatch):
    """Where its package is installed; without, the others are."""
    file = robots.models().get(robots.H1)
    if file is not None:
        assert [one.simulator for one in robots.robots(False) if one.name == robots.H1] == [
            *SIMULATORS,
            robots.AS_IT_IS,
        ]
    monkeypatch.setattr(robots, "PACKAGE", "no-such-robots")
    assert {one.simulator for one in robots.robots(False)} == set(SIMULATORS)


def test_a_scene_has_the_published_file_and_level_ground(tmp_path):
    """And the meshes beside it."""
    made = tmp_path / "made"
    made.mkdir()
    (made / "box.xml").write_text(
        '<mujoco><worldbody><body name="b" pos="0 0 1"><freejoint/><geom size="0.1"/></body>'
        "</worldbody></mujoco>"
    )
    (made / "mesh.obj").write_text("v 0 0 0")
    file = robots.scene(made / "box.xml", tmp_path / "copy")
    model = mujoco.MjModel.from_xml_path(file)
    assert (model.nbody, model.ngeom, model.nv) == (2, 2, 6)
    assert (tmp_path / "copy" / "mesh.obj").exists()
