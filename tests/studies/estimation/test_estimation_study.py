"""The study of the state estimator: its numbers from made-up walks."""

import numpy as np
import pytest

from studies.common.trials import FRESH
from studies.estimation.__main__ import page_of, wanted
from studies.estimation.summary import BARS, nees_inside, summarize
from studies.estimation.walks import LOSSES, SEEN, SPEEDS, Walk, lost


def made_up(kind, index=0, on=True, **changes):
    row = {"kind": kind, "index": index, "on_estimate": on, "size": 0.0, "upright": True}
    return row | {"reason": "", "way": 10.0, "speed": None, "errors": []} | changes


def long_walk(index, off):
    """Errors at 1 s and 2 s: all numbers 0 but those of the last place, heading and velocity."""
    errors = np.zeros((2, 23))
    errors[:, 0], errors[-1, 7:10], errors[-1, 3] = [1.0, 2.0], [0.3, 0.4, off], np.radians(1.0)
    errors[:, 19], errors[:, 1], errors[:, -1] = 0.02, np.radians(0.2), len(SEEN)
    return made_up("drift", index, errors=errors.tolist())


@pytest.fixture
def rows():
    found = [long_walk(0, 0.03), long_walk(1, -0.03)]
    found += [made_up(k, i, on) for k in LOSSES for i in range(4) for on in (True, False)]
    for i in range(20):
        stays = {1.2: True, 1.3: i > 0, 1.4: i > 9}  # lower ends of 0.84, 0.76, 0.30
        found += [
            made_up("forward", i, size=speed, upright=stays[speed], speed=0.9 * speed)
            for speed in SPEEDS
        ]
    return found


def test_numbers_of_made_up_walks(rows):
    rows[2]["upright"] = False  # one of four on the estimate, of the first kind
    found = summarize(rows, 0.4)
    assert found["drift_xy_percent"] == pytest.approx(5.0)
    assert found["drift_z_m"] == pytest.approx(0.03)
    assert found["drift_yaw_deg"] == pytest.approx(1.0)
    assert found["velocity_rmse"] == pytest.approx(0.02)
    assert found["tilt_rmse_deg"] == pytest.approx(np.sqrt(0.5) * 0.2)
    assert found["nees_inside"] == 1.0
    assert [found[f"loss_{kind}"] for kind in LOSSES] == [25.0, 0.0, 0.0, 0.0]
    assert found["forward_on_estimate"] == 1.2
    assert [one["upright"] for one in found["ahead"]] == [20, 19, 10]
    assert [one["met"] for one in found["ahead"]] == [True, None, False]
    assert found["ahead"][1]["speed"] == pytest.approx(1.17)
    assert found["bars"]["forward_on_estimate"]["met"] is None
    assert found["bars"]["drift_yaw_deg"]["met"] and not found["bars"]["drift_xy_percent"]["met"]


@pytest.mark.parametrize("fallen, met", [((0, 0), True), ((3, 3), None), ((20, 0), False)])
def test_a_loss_is_judged_by_all_of_its_interval(rows, fallen, met):
    """Of 200 pairs, on the estimate and on the truth: 20 lost are 10 +- 4 points."""
    rows = [row for row in rows if row["kind"] != "wide"]
    for i in range(200):
        on_estimate, on_truth = i >= fallen[0], i < 200 - fallen[1]
        rows += [made_up("wide", i, True, upright=on_estimate)]
        rows += [made_up("wide", i, False, upright=on_truth)]
    found = summarize(rows, 0.4)
    group, bar = found["groups"]["wide"], found["bars"]["loss_wide"]
    assert (group["lost"], group["won"], group["runs"]) == (*fallen, 200)
    assert group["estimate"] == 200 - fallen[0] and group["truth"] == 200 - fallen[1]
    assert bar["met"] is met
    assert bar["interval"][0] < bar["value"] < bar["interval"][1]


def test_nees_beyond_its_bounds_counts_as_outside():
    errors = np.zeros((4, 23))
    errors[:, 0], errors[:, -1] = [0.1, 1.0, 2.0, 3.0], [99.0, 5.0, 50.0, 0.01]
    assert nees_inside([errors]) == pytest.approx(1.0 / 3.0)


def test_the_page_has_every_bar_and_says_what_is_missed(rows):
    about = {"seeds": 2, "runs": 4, "way_m": 10.0, "command": "it", "made_with": {"drake": "1"}}
    page = page_of(summarize(rows, 0.7) | about, rows)
    assert all(f"`{key}`" in page for key in BARS)
    assert "A quick look: long walks of 10 m, 2 seeds, groups of 4" in page
    line = next(line for line in page.splitlines() if "estimator_tick" in line)
    assert line.endswith("| **NO** |")
    assert "| 1.3 | 1.170 | 19 | 20 | 76.4 % | undecided |" in page


def test_walks_are_on_seeds_of_their_own_and_in_pairs():
    walks = wanted(20, 200, 100.0)
    assert len({walk.key for walk in walks}) == len(walks) == 20 + 60 + 1600
    assert {walk.index for walk in walks if walk.kind in LOSSES} == {*range(200)}
    assert min(walk.index for walk in walks if walk.kind not in LOSSES) == FRESH
    row = lost(walks[-1], "it crashed")
    assert row["key"] == walks[-1].key and not row["upright"]


def test_a_walk_of_the_study():
    walk = Walk("drift", 0, True, 1.0)
    scenario = walk.scenario()
    assert scenario.estimation and scenario.duration == 11.0
    pairs = [Walk("push_10", 3, on).scenario() for on in (True, False)]
    assert [pair.estimation for pair in pairs] == [True, False]
    assert pairs[0].segments == pairs[1].segments and pairs[0].pushes == pairs[1].pushes
