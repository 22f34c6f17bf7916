"""The study of the state estimator: its numbers from made-up walks."""

import numpy as np
import pytest

from studies.estimation.__main__ import BARS, nees_inside, page_of, summarize
from studies.estimation.walks import LOSSES, SEEN, SPEEDS, Walk


def made_up(kind, index=0, on=True, **changes):
    row = {"kind": kind, "index": index, "on_estimate": on, "size": 0.0, "upright": True}
    return row | {"reason": "", "way": 10.0, "refused": 0.0, "errors": []} | changes


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
    found += [made_up("forward", size=speed, upright=speed < 1.35) for speed in SPEEDS]
    return found


def test_numbers_of_made_up_walks(rows):
    rows[2]["upright"] = False  # one of four on the estimate, of the first kind
    found = summarize(rows)
    assert found["drift_xy_percent"] == pytest.approx(5.0)
    assert found["drift_z_m"] == pytest.approx(0.03)
    assert found["drift_yaw_deg"] == pytest.approx(1.0)
    assert found["velocity_rmse"] == pytest.approx(0.02)
    assert found["tilt_rmse_deg"] == pytest.approx(np.sqrt(0.5) * 0.2)
    assert found["nees_inside"] == 1.0
    assert [found[f"loss_{kind}"] for kind in LOSSES] == [25.0, 0.0, 0.0, 0.0]
    assert found["forward_on_estimate"] == 1.3


def test_nees_beyond_its_bounds_counts_as_outside():
    errors = np.zeros((4, 23))
    errors[:, 0], errors[:, -1] = [0.1, 1.0, 2.0, 3.0], [99.0, 5.0, 50.0, 0.01]
    assert nees_inside([errors]) == pytest.approx(1.0 / 3.0)


def test_the_page_has_every_bar_and_says_what_is_missed(rows):
    summary = summarize(rows) | {"estimator_tick_over_plant_step": 0.7}
    about = {"seeds": 2, "way_m": 10.0, "command": "it", "made_with": {"drake": "1"}}
    page = page_of(summary, about, rows)
    assert all(f"`{key}`" in page for key in BARS)
    assert "A quick look: 2 seeds" in page
    line = next(line for line in page.splitlines() if "estimator_tick" in line)
    assert line.endswith("| no |")


def test_a_walk_of_the_study():
    walk = Walk("drift", 0, True, 1.0)
    scenario = walk.scenario()
    assert scenario.estimation and scenario.duration == 11.0
    pairs = [Walk("push_10", 3, on).scenario() for on in (True, False)]
    assert [pair.estimation for pair in pairs] == [True, False]
    assert pairs[0].segments == pairs[1].segments and pairs[0].pushes == pairs[1].pushes
