"""What the study of known ground says of its trials."""

import pytest

from studies.ground.__main__ import HEAD, cells_of
from studies.ground.summary import holds, summed


@pytest.mark.parametrize(
    ("done", "runs", "bar", "holding"),
    [
        (5, 5, 0.95, None),  # of so few the lower end is 57 %
        (100, 100, 0.95, True),  # 96.3 %
        (195, 200, 0.95, None),  # 94.3 to 98.9 %
        (198, 200, 0.95, True),  # 96.4 %
        (2, 5, 0.85, False),  # 11.8 to 76.9 %
        (0, 1, 0.7, None),  # 0 to 79.3 %
    ],
)
def test_a_bar_is_met_by_the_lower_end(done, runs, bar, holding):
    assert holds(done, runs, bar) is holding


def test_cases_are_summed_each_by_itself():
    one = {"done": True, "speed": 0.4, "cut": 100, "over_edge": 1, "landings": 20}
    fallen = {"done": False, "speed": None, "cut": 900, "over_edge": 3, "landings": 10}
    rows = [{"case": "stairs_up_12"} | row for row in (one, one, fallen)]
    found = summed([*rows, {"case": "gaps_20"} | one])
    assert set(found) == {"stairs_up_12", "gaps_20"}
    up = found["stairs_up_12"]
    assert (up["runs"], up["done"], up["share"]) == (3, 2, pytest.approx(2 / 3))
    assert (up["speed"], up["cut"]) == (pytest.approx(0.4), 100)
    cells = dict(zip(HEAD, cells_of("stairs_up_12", up), strict=True))
    assert cells["over an edge"] == "5 of 50"
    assert cells["done"] == "66.7%"
    assert cells["met"] == "**NO**"  # of two in three the upper end is 93.9 %
