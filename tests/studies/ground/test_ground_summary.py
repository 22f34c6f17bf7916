"""What the study of known ground says of its trials."""

import numpy as np
import pytest

from drake_linefoot.lab.plants.scene import ground_of
from drake_linefoot.lab.scenario.load import validate
from studies.common.paired import Draw, kind
from studies.ground.__main__ import HEAD, cells_of
from studies.ground.cases import CASES, Trial, goal_of, length_of, progress, scenario
from studies.ground.summary import bars, summed


def test_cases_are_summed_each_by_itself():
    one = {"done": True, "speed": 0.4, "cut": 100, "over_edge": 1, "landings": 20}
    fallen = {"done": False, "speed": None, "cut": 900, "over_edge": 3, "landings": 10}
    rows = [{"case": "stairs_up_12"} | row for row in (one, one, fallen)]
    found = summed([*rows, {"case": "gaps_20"} | one])
    assert set(found) == {"stairs_up_12", "gaps_20"}
    up = found["stairs_up_12"]
    assert (up["runs"], up["done"]) == (3, 2)
    assert (up["speed"], up["cut"]) == (pytest.approx(0.4), 100)
    cells = dict(zip(HEAD, cells_of("stairs_up_12", up), strict=True))
    assert cells["over an edge"] == "5 of 50"
    assert (cells["runs"], cells["done"]) == ("3", "2")


def test_what_is_asked_is_judged_case_by_case():
    some = {"runs": 3, "done": 2, "speed": 0.4, "cut": 100, "over_edge": 5, "landings": 50}
    many = some | {"runs": 200, "done": 197, "cut": 20, "over_edge": 0}
    pairs = {"runs": 100, "drake": 97, "known": 96, "known_lost": 1, "known_won": 0}
    fewer = pairs | {"known": 77, "known_lost": 20}
    found = bars(
        {"stairs_up_12": many, "stairs_down_12": some, "gaps_20": many},
        {"wide": pairs, "wide_push": fewer},
    )
    met = {key: bar["met"] for key, bar in found.items()}
    assert met == {
        "stairs_up_12": True,  # from 95.7 to 99.5 %
        "stairs_down_12": False,  # of two in three the upper end is 93.9 %
        "gaps_20": True,
        "speed_on_stairs": None,  # that case was not tried
        "torques_cut": True,
        "over_edge": False,
        "known_wide": True,  # one point fewer, from -1.9 to 3.9
        "known_wide_push": False,
    }
    assert found["over_edge"]["value"] == 5
    assert bars({}, {})["over_edge"]["met"] is None


@pytest.mark.parametrize("name", CASES)
def test_every_case_can_be_run(name):
    """Its scenario is valid, the robot as said, and as long as its course needs."""
    made, case = validate(scenario(Trial(name, 3))), CASES[name]
    assert made.plant.simulator == case.simulator
    assert (made.robot == "mit_humanoid") is not case.on_soles
    assert made.duration * case.speed > 2.0


def test_progress_on_a_spiral_is_along_its_arc():
    trial = Trial("spiral_12", 0)
    made = scenario(trial)
    course, ground = made.ground.spiral, ground_of(made)
    x, y = np.meshgrid(np.linspace(-1.0, 5.0, 121), np.linspace(-1.0, 5.0, 121))
    z = ground.height(x, y).ravel()
    along = progress(course, np.column_stack([x.ravel(), y.ravel()]))
    on = np.isfinite(z)
    step = np.clip(np.floor(along[on] / course.tread - 1e-9) + 1, 0, course.steps)
    same = np.isclose(z[on], course.rise * step, atol=1e-9)
    assert same.mean() > 0.97  # but for edges
    assert goal_of(course) > length_of(course) == pytest.approx(7 * 0.28)


def test_trials_are_of_a_kind_and_draws_of_another():
    jobs = [Trial("gaps_20", 500), Trial("stones", 501), Draw("wide", 3, "known")]
    assert [kind(job.key) for job in jobs] == ["case", "case", "known"]
