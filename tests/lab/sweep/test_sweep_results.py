"""What a sweep comes to: rates, intervals, table, plots and report."""

import base64
import gzip
import json
import re

import numpy as np
import pyarrow.parquet
import pytest

from drake_linefoot.errors import InputError
from drake_linefoot.fields import unit_of
from drake_linefoot.lab.results.provenance import differences, digest, made_with
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.scenario.paths import parts_of
from drake_linefoot.lab.sweep.file import load_sweep
from drake_linefoot.lab.sweep.maps import bin_of, informativeness, map_figures, numbers
from drake_linefoot.lab.sweep.page import rate_row, sweep_page
from drake_linefoot.lab.sweep.rows import FAILED, row_of
from drake_linefoot.lab.sweep.statistics import (
    clears,
    compare_groups,
    interval,
    loss_interval,
    summarize_group,
    summarize_groups,
    worst,
)
from drake_linefoot.lab.sweep.table import column, read_table, table, write_table
from tests.helpers.tiny_sweeps import made_up_row, write_sweep


@pytest.mark.parametrize(("k", "n"), [(0, 5), (5, 5), (3, 7), (199, 200), (1, 1)])
def test_interval_is_wilsons(k, n):
    z = 1.959963984540054  # 97.5 % quantile of the normal distribution
    centre = (k + z**2 / 2.0) / (n + z**2)
    half = z / (n + z**2) * np.sqrt(k * (n - k) / n + z**2 / 4.0)
    assert interval(k, n) == pytest.approx((centre - half, centre + half), abs=1e-12)


@pytest.mark.parametrize("lost, won", [(0.05, 0.05), (0.1, 0.02), (0.01, 0.2)])
def test_interval_of_a_loss_has_the_true_one_in_it(lost, won):
    """In 95 % of made-up groups of 200 pairs, to 2 %."""
    random = np.random.default_rng(0)
    counts = random.multinomial(200, [lost, won, 1.0 - lost - won], size=4000)
    ends = np.array([loss_interval(a, b, 200) for a, b, _ in counts])
    inside = (ends[:, 0] <= lost - won) & (lost - won <= ends[:, 1])
    assert np.mean(inside) == pytest.approx(0.95, abs=0.02)
    low, high = loss_interval(0, 0, 200)
    assert high == -low and 0.005 < high < 0.02


def test_summary_counts_every_run_once():
    rows = [
        made_up_row(index=0),
        made_up_row(index=1, fell=True, attempts=2),
        made_up_row(index=2, fell=True, cause="slip", fall_time=2.5),
        made_up_row(index=3, fell=True),
        made_up_row(index=4, fell=None, cause="error", error="ValueError: x", roll_max=None),
    ]
    summary = summarize_group(rows)
    assert (summary["n"], summary["upright"], summary["rate"]) == (5, 1, 0.2)
    assert (summary["fell"], summary["errors"], summary["redone"]) == (3, 1, 1)
    assert list(summary["causes"].items()) == [("torso low", 2), ("slip", 1), ("error", 1)]
    assert summary["fall_time"] == 1.5
    assert summary["roll_max"] == {"median": 0.1, "p95": 0.1, "max": 0.1}
    assert summary["contact_latency"] is None
    json.dumps(summary, allow_nan=False)
    assert summarize_group([])["rate"] is None


def test_groups_are_compared_run_by_run():
    """Ten runs of which one group loses seven that the other does not; run 10 has no partner."""
    first = [made_up_row(index=i, fell=i == 9) for i in range(10)]
    second = [made_up_row(index=i, fell=i < 7) for i in range(11)]
    groups = summarize_groups({"a": first, "b": second})
    assert "against" not in groups["a"]
    p = 2.0 * (1 + 8) / 2**8  # of eight fair coins at most one shows heads, or all but one
    assert groups["b"]["against"] == {"group": "a", "won": 1, "lost": 7, "p": pytest.approx(p)}
    assert rate_row("b", groups["b"])[-1] == "1, 7 (0.07)"
    assert rate_row("a", groups["a"])[-1] == "-"
    assert compare_groups([], first) == {"won": 0, "lost": 0, "p": 1.0}


def test_worst_are_falls_the_earliest_first_and_then_tilt():
    rows = [
        made_up_row(index=0, roll_max=0.3),
        made_up_row(index=1, fell=True, fall_time=3.0),
        made_up_row(index=2, pitch_max=0.4),
        made_up_row(index=3, fell=True, fall_time=0.5),
        made_up_row(index=4, fell=None, error="broke"),
    ]
    assert [row["index"] for row in worst(rows, 9)] == [3, 1, 2, 0]
    assert worst(rows, 0) == []


@pytest.mark.parametrize(
    ("path", "unit"),
    [
        ("gait.step_width", "m"),
        ("segments[1].velocity[0]", "m/s"),
        ("segments[0].turn_rate", "rad/s"),
        ("perturbation.joint_velocity", "rad/s"),
        ("plant.time_step", "s"),
        ("ground.slope", "rad"),
        ("mpc.model", "-"),
    ],
)
def test_units_are_those_of_the_scenario(path, unit):
    assert unit_of(Scenario, parts_of(path)) == unit


@pytest.mark.parametrize(
    ("values", "held"),
    [
        ([1, None, 2], [1, None, 2]),
        ([1, 2.5], [1.0, 2.5]),
        ([True, None], [True, None]),
        (["a", [1, 2]], ["a", "[1, 2]"]),
    ],
)
def test_sampled_values_fit_one_column(values, held):
    found = column(values).to_pylist()
    assert found == held
    assert [type(v) for v in found] == [type(v) for v in held]


def test_table_has_a_row_a_run_and_units(tmp_path):
    class Job:
        group, index, seed, sampled = "high", 1, 5, {"seed": 5, "y": "b"}

    work = {"error": "its worker died", "attempts": 2}
    rows = [made_up_row(index=0), row_of(Job, FAILED, work)]
    write_table(tmp_path / "t.parquet", rows, {"seed": "-", "x": "m", "y": "-"}, {"sweep": "a"})
    found = pyarrow.parquet.read_table(tmp_path / "t.parquet")
    assert found.num_rows == 2
    assert found.column("x").to_pylist() == [0.0, None]
    assert found.column("y").to_pylist() == [None, "b"]
    assert found.column("seed").to_pylist() == [0, 5]
    assert found.column("fell").to_pylist() == [False, None]
    assert found.column("attempts").to_pylist() == [1, 2]
    assert found.schema.field("x").metadata[b"unit"] == b"m"
    assert found.schema.field("roll_max").metadata[b"unit"] == b"rad"
    assert table([], {"x": "m"}, {}).num_rows == 0


def test_table_is_read_as_it_was_written(tmp_path):
    rows = [made_up_row(index=0), made_up_row("high", 1, True, sampled={"y": 0.5})]
    write_table(tmp_path / "t.parquet", rows, {"x": "m", "y": "s"}, {"sweep": "a"})
    assert read_table(tmp_path / "t.parquet") == (rows, {"x": "m", "y": "s"}, {"sweep": "a"})


@pytest.mark.parametrize("content", [None, b"", b"PAR1 no table PAR1"])
def test_what_is_no_table_is_refused(tmp_path, content):
    if content is not None:
        (tmp_path / "t.parquet").write_bytes(content)
    with pytest.raises(InputError, match=r"t\.parquet"):
        read_table(tmp_path / "t.parquet")


def mixed_rows(n=40):
    """Runs that fall where x is large; y says nothing."""
    rng = np.random.default_rng(0)
    sampled = [
        {"seed": i, "x": float(x), "y": float(y), "z": "a"}
        for i, (x, y) in enumerate(rng.random((n, 2)))
    ]
    return [made_up_row(index=i, fell=d["x"] > 0.7, sampled=d) for i, d in enumerate(sampled)]


def test_informative_parameter_comes_first():
    rows = mixed_rows()
    sampled, good = numbers(rows), np.array([not row["fell"] for row in rows])
    assert set(sampled) == {"x", "y"}
    assert informativeness(sampled["x"], good) > 2.0 * informativeness(sampled["y"], good)
    assert informativeness(sampled["x"], np.full(len(rows), True)) == 0.0
    every, rates = map_figures({"low": rows}, {"x": "m", "y": "s"}).values()
    assert every.layout.xaxis.title.text == "x [m]"
    upright, fallen = every.data
    assert len(upright.x) + len(fallen.x) == 40
    assert min(fallen.x) > 0.7
    assert rates.layout.xaxis.title.text == "x [m]"
    share = np.array(rates.data[0].y)
    assert (share[0], share[-1]) == (100.0, 0.0)


def test_bins_hold_equally_many_and_equal_values_stay_together():
    assert np.bincount(bin_of(np.arange(50.0))).tolist() == [10] * 5
    assert len(set(bin_of(np.array([0.0] * 9 + [1.0] * 9)))) == 2


def test_page_has_rates_causes_links_and_plots(tmp_path):
    file = write_sweep(tmp_path)
    sweep, rows = load_sweep(file), mixed_rows()
    groups = {"low": rows, "high": []}
    summary = {
        "made_with": {"code": "0123"},
        "groups": {name: summarize_group(some) for name, some in groups.items()},
    }
    listed = [(rows[0], "replays/a.html"), (rows[1], "")]
    page = sweep_page(sweep, groups, summary, {"x": "m"}, listed, file)
    low = summary["groups"]["low"]
    assert f"{100.0 * low['rate']:.1f} %" in page
    assert f"{100.0 * low['low']:.1f} to {100.0 * low['high']:.1f} %" in page
    assert "torso low" in page
    assert page.count('href="replays/') == 1
    assert "40 of 8 runs" not in page  # more than planned is complete
    assert "perturbation.joint_velocity [rad/s]" not in page  # units are those that are given
    (packed,) = re.findall(r'id="figures">([A-Za-z0-9+/=]+)</script>', page)
    figures = json.loads(gzip.decompress(base64.b64decode(packed)))
    assert all(f'<div id="{key}"></div>' in page for key in figures)
    assert len(figures) == 2
    shell = re.sub(r'id="(library|figures)">[^<]+<', "", page)
    assert re.findall(r"https?:|src=|@import|<link", shell) == []


def test_a_digest_is_of_names_and_contents(tmp_path):
    (tmp_path / "sub").mkdir()

    def found():
        return digest({tmp_path: tmp_path.rglob("*.py")})

    seen = {found()}
    for name, text in (("sub/a.py", "1"), ("sub/a.py", "2"), ("a.pyc", "1"), ("a.py", "2")):
        (tmp_path / name).write_text(text)
        seen.add(found())
    (tmp_path / "a.py").unlink()
    assert len(seen) == 4 and found() in seen


def test_what_a_result_is_made_with_tells_the_controller_from_the_lab():
    found = made_with()
    assert found["controller"] != found["lab"] and ".dev" not in found["drake_linefoot"]


def test_differences_are_said():
    assert differences({"a": "1"}, {"a": "1"}) == ""
    assert differences({"a": "1"}, {"a": "2", "b": "3"}) == "a 2 instead of 1, b 3 instead of None"


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
    assert clears(done, runs, bar) is holding
