"""The numbers in the README are those of the files that they come from, to the digits they have.

When one fails, the README is what to change. The table of the first walk is in `test_walk.py`.
"""

import json
import re
from pathlib import Path

import yaml

from drake_linefoot.lab.scenario.load import load_scenario
from studies.estimation.walks import LOSSES

ROOT = Path(__file__).resolve().parents[1]
README = " ".join((ROOT / "README.md").read_text(encoding="utf-8").split())


def said(pattern):
    """The numbers that the groups of a pattern find in the README, as they are written there."""
    found = re.search(pattern, README)
    assert found, pattern
    return found.groups()


def rounded(values, texts):
    """Values to as many decimals as the texts have."""
    return tuple(f"{v:.{len(t.partition('.')[2])}f}" for v, t in zip(values, texts, strict=True))


def published(file):
    return json.loads((ROOT / "docs" / file).read_text(encoding="utf-8"))


def test_versions_of_drake_are_those_that_are_installed():
    lock = (ROOT / "requirements/base.txt").read_text(encoding="utf-8")
    pins = re.findall(r"^drake==(\S+) ; python_full_version (\S+) '([\d.]+)'", lock, re.MULTILINE)
    older, newer, since = said(r"Drake (\S+) on Python 3\.11, Drake (\S+) on (\S+) and newer")
    assert sorted(pins) == [(older, "<", since), (newer, ">=", since)]


def test_the_first_walk_and_the_sweep_are_as_long():
    (seconds,) = said(r"simulate ([\d.]+) s of walking")
    assert float(seconds) == load_scenario("walk").duration
    (runs,) = said(r"linefoot sweep examples/sweeps/nominal\.yaml # (\d+) random walks")
    sweep = yaml.safe_load((ROOT / "examples/sweeps/nominal.yaml").read_text(encoding="utf-8"))
    assert int(runs) == sweep["runs"]


CASES = {
    "wide": "undisturbed",
    "wide_push_10": "a push of 10 N s, in any direction",
    "wide_push_20": "a push of 20 N s",
    "stand_push_15": "standing, a push of 15 N s",
    "wide_rough_5": "tiles of +-5 cm",
    "wide_slope_15": "a slope of 15 degrees",
    "wide_slippery": "friction of 0.4 where 0.6 is assumed; estimated from foot slip",
    "wide_model_error": "model errors, delays, noise and a push of 10 N s",
}


def test_the_table_of_runs_is_that_of_the_sweeps():
    rows = re.findall(r"\| ([^|]+) \| (\d+) of (\d+) \| ([\d.]+) to ([\d.]+) % \|", README)
    groups = published("robustness/summary.json")["groups"]
    assert rows == [
        (
            words,
            str(groups[name]["upright"]),
            str(groups[name]["n"]),
            *rounded((100.0 * groups[name]["low"], 100.0 * groups[name]["high"]), ("0.0", "0.0")),
        )
        for name, words in CASES.items()
    ]


def test_what_is_said_of_runs_is_what_their_study_found():
    fastest, flight, running, walking = said(
        r"up to (\S+) m/s, with flights of (\d+) ms; at 2\.0 m/s a torque is at its limit in "
        r"(\d+) % of the ticks at most \(in a walk at 1\.4 m/s in (\d+) %\)"
    )
    study = published("running/summary.json")
    assert rounded([study["bars"]["run_forward"]["value"]], [fastest]) == (fastest,)
    run, walk = (
        {row["size"]: row for row in study["ladders"][way]}
        for way in ("run_forward", "walk_forward")
    )
    found = 1e3 * run[2.0]["flight"], 100.0 * run[2.0]["limited"], 100.0 * walk[1.4]["limited"]
    assert rounded(found, (flight, running, walking)) == (flight, running, walking)


def test_courses_are_walked_as_often_as_their_study_found():
    words = said(
        r"it climbed stairs of 12 cm in (\d+) of (\d+) runs and descended them in (\d+); gaps of "
        r"20 cm it crossed in (\d+), stones of 25 cm in (\d+)\."
    )
    up, runs, *others = map(int, words)
    cases = published("ground/summary.json")["cases"]
    found = [cases[key] for key in ("stairs_up_12", "stairs_down_12", "gaps_20", "stones")]
    assert [case["done"] for case in found] == [up, *others]
    assert {case["runs"] for case in found} == {runs}


def test_times_are_those_of_the_benchmark():
    texts = said(r"at 1 kHz costs (\S+) plant steps, (\S+) times as fast as real time")
    bench = published("bench.json")
    values = bench["closed_loop_over_plant_step"], bench["realtime_rate_1khz"]
    assert rounded(values, texts) == texts


def test_the_estimate_is_off_by_what_its_study_found():
    way, *texts, walks, each, on_it, true = said(
        r"After (\d+) m it is off by (\S+) m, (\S+) m in height and (\S+) degrees;\s+"
        r"of (\d+) walks, (\d+) each undisturbed, after a push, on tiles and on a slope, "
        r"(\d+) stay upright on it, of the same on the true state (\d+)"
    )
    study = published("estimation/summary.json")
    off = study["way_m"] * study["drift_xy_percent"] / 100.0
    values = off, study["drift_z_m"], study["drift_yaw_deg"]
    assert rounded(values, texts) == tuple(texts)
    assert float(way) == study["way_m"]
    groups = study["groups"]
    assert [*groups] == [*LOSSES] == ["wide", "push_10", "tiles", "slope_10"]
    assert {group["runs"] for group in groups.values()} == {int(each)}
    assert int(walks) == len(groups) * int(each)
    assert int(on_it) == sum(group["estimate"] for group in groups.values())
    assert int(true) == sum(group["truth"] for group in groups.values())
