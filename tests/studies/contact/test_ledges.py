"""Steps in the ground: which touchdown is the first beyond one, and what it came to."""

import json
from dataclasses import replace

import numpy as np
import pytest

from drake_linefoot.lab.plants.scene import ground_of
from drake_linefoot.lab.scenario.disturbances import GroundParameters
from drake_linefoot.lab.scenario.load import validate
from studies.common.command import run
from studies.contact import __main__ as contact_study
from studies.contact.__main__ import contact
from studies.contact.ledges import crossings, first_touch, summarize
from tests.helpers.recorded_runs import make_run

TIME = np.arange(0.0, 1.0, 0.001)
LEDGE = GroundParameters(ledge_height=-0.03, ledge_at=1.0)


def main(arguments):
    return run(contact, "contact", arguments)


def steps(heights, places):
    """A right foot that lands at 0.2 s and at 0.6 s; the left one stands at x = 0."""
    points = np.zeros((len(TIME), 2, 2, 3))
    normal = np.full((len(TIME), 2, 2), 60.0)
    normal[:200, 1] = normal[400:600, 1] = 0.0
    for begin, z, x in zip((200, 600), heights, places, strict=True):
        points[begin:, 1, :, 2] = z
        points[begin:, 1, :, 0] = [x - 0.075, x + 0.075]
    return make_run(TIME, contact_points=points, true_normal=normal)


def test_first_touchdown_beyond_a_ledge():
    assert first_touch(steps((0.0, -0.03), (0.8, 1.2)), LEDGE) == (1, 600)
    assert first_touch(steps((-0.03, -0.03), (1.2, 1.4)), LEDGE) == (1, 200)
    assert first_touch(steps((0.0, 0.0), (0.8, 1.2)), LEDGE) is None  # not on its level
    assert first_touch(steps((0.0, -0.03), (0.8, 0.9)), LEDGE) is None  # not there yet


def test_crossings_are_spread_over_speeds_and_the_stride_and_can_be_simulated():
    chosen = crossings(4)
    assert len(chosen) == 16
    assert sorted({c.speed for c in chosen}) == pytest.approx([0.3, 0.4, 0.5, 0.6])
    shares = sorted({(c.at - 0.8) / (0.46 * c.speed) for c in chosen})  # [s] of a stride
    assert shares[0] >= 0.0
    assert shares[-1] < 1.0
    assert len(np.unique(np.round(shares, 6))) == 4
    assert np.diff(shares).min() > 0.1
    for crossing in chosen:
        scenario = crossing.scenario()
        validate(scenario)
        height = ground_of(scenario).height([crossing.at - 0.01, crossing.at + 0.01], [0.0, 0.0])
        assert height == pytest.approx([0.0, 0.03 if crossing.case == "up" else -0.03])


def test_summary_of_each_case():
    row = {"case": "up", "feedback": True, "upright": True, "impact_n": 100.0, "latency_ms": 2.0}
    row |= {"roll_rad": 0.1, "pitch_rad": 0.2, "cause": "upright"}
    fallen = {**row, "upright": False, "impact_n": 300.0, "latency_ms": None}
    never = {**row, "feedback": False, **dict.fromkeys(("impact_n", "latency_ms"))}
    (on, off) = summarize([row, fallen, never])
    assert (on["n"], on["upright"], on["missed"], on["latency_ms"]) == (2, 1, 1, 2.0)
    assert (on["impact_n"], on["impact_n_max"]) == (200.0, 300.0)
    assert (off["n"], off["feedback"], off["impact_n"], off["missed"]) == (1, False, None, 0)


@pytest.mark.slow
def test_command_writes_page_numbers_and_picture(tmp_path, capsys, monkeypatch):
    less = replace(contact_study.QUICK, duration=1.2, touches=(50.0,))
    monkeypatch.setattr(contact_study, "QUICK", less)
    words = ["--quick", "--workers", "1", "--out", str(tmp_path)]
    assert main(words) == 0
    assert capsys.readouterr().out.splitlines()[-1] == str(tmp_path / "contact.md")
    data = json.loads((tmp_path / "contact.json").read_text(), parse_constant=pytest.fail)
    felt = {row["case"]: row for row in data["ledges"]["walks"] if row["feedback"]}
    assert set(felt) == {"up", "down"}
    for row in felt.values():
        assert row["upright"]
        assert row["latency_ms"] < 20.0
        assert 100.0 < row["impact_n"] < 1e4  # [N], of a robot that weighs 240 N
        assert 0.0 < row["roll_rad"] < 0.3
    assert set(data["forms"]) == {"nominal", "rough", "pushed", "noisy"}
    page = (tmp_path / "contact.md").read_text()
    assert "python -m studies.contact --quick" in page
    assert "(contact.png)" in page
    assert (tmp_path / "contact.png").stat().st_size > 10_000
