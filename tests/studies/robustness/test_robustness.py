"""What sweeps come to, held against the thresholds: from tables that nobody simulated."""

import io
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from drake_linefoot.errors import InputError
from drake_linefoot.lab.sweep.file import load_sweep
from drake_linefoot.lab.sweep.jobs import header_of
from drake_linefoot.lab.sweep.journal import open_journal
from drake_linefoot.lab.sweep.rows import key_of
from drake_linefoot.lab.sweep.table import read_table, write_table
from studies.common import paired
from studies.common.bars import bar_table
from studies.common.command import run
from studies.common.published import go_on_from, hold_over
from studies.common.stamp import Probed, made_by
from studies.estimation import walks
from studies.robustness import __main__ as command
from studies.robustness import probe as quick
from studies.robustness.__main__ import read_tables, robustness, write_robustness
from studies.robustness.summary import BARS, contact_figures, punches, robustness_summary
from tests.helpers.command_line import refuse
from tests.helpers.tiny_sweeps import made_up_row, write_sweep

SEEN = (
    "slip -90 ms (left), late step -40 ms (70 mm, 20 ms), solver +0 ms (9 times), roll 0 to 1 rad"
)
MADE_WITH = {"drake_linefoot": "0.1.0", "code": "abc"}


def main(arguments):
    return run(robustness, "robustness", arguments)


def rows_of(group, upright, n, **changes):
    known = {"steps": 40, "false_contacts": 0, "missed_contacts": 0, "contact_latency": 2.0}
    known |= {
        "simulated": 10.0,
        "fall_indicators": "",
        "leg_gap": 0.03,
        "legs_met": None,
        **changes,
    }
    rows = [made_up_row(group, i, fell=i >= upright, **known) for i in range(n)]
    for i, row in enumerate(rows):
        row["sampled"] = {"x": i / n, "seed": i}
        if row["fell"]:
            row |= {"cause": "slip" if i % 3 else "late step", "fall_indicators": SEEN}
    return rows


def write(folder, name, rows):
    about = {"name": name, "seed": 1, "made_with": MADE_WITH}
    units = {path: "-" for row in rows for path in row["sampled"]}
    write_table(folder / f"{name}.parquet", rows, units, about)
    return folder / f"{name}.parquet"


@pytest.fixture
def tables(tmp_path):
    pushed = [*rows_of("wide_push_10", 195, 200), *rows_of("wide_push_15", 184, 200)]
    others = [*rows_of("wide_push_20", 60, 200), *rows_of("wide_model_error", 170, 200)]
    any_push = rows_of("wide_push", 150, 200)
    for i, row in enumerate(any_push):
        row["viable"] = i < 160  # of which 150 are upright
        row["sampled"] |= {"pushes[0].direction": 0.1 * i, "pushes[0].impulse": 10.0 + 0.1 * i}
    nominal = rows_of("wide", 199, 200, contact_latency=9.0, speed_error=0.125)
    return [
        write(tmp_path, "nominal", nominal),
        write(tmp_path, "robustness", [*pushed, *others, *any_push]),
    ]


def test_summary_has_a_plain_number_for_each_key_and_judges_it(tables, tmp_path):
    write_robustness(tables, tmp_path, "python -m studies.robustness")
    found = json.loads((tmp_path / "summary.json").read_text())
    assert found["wide"] == 0.995
    pushed = found["wide_push_10"], found["wide_push_15"], found["wide_push_20"]
    assert pushed == (0.975, 0.92, 0.3)
    assert found["viable_survived"] == 150 / 160
    assert found["wide_slope_10"] is None  # no such group
    assert (found["latency_ms"], found["false_contact_rate"]) == (9.0, 0.0)
    met = {key: bar["met"] for key, bar in found["bars"].items()}
    assert {key: value for key, value in met.items() if value is not None} == {
        "wide_push_20": False,  # of 199, 195 and 184 of 200 the intervals have the bars within
        "wide_model_error": False,
        "viable_survived": True,
        "latency_ms": False,
        "false_contact_rate": True,
    }
    wide = found["groups"]["wide_push_15"]
    assert (wide["n"], wide["rate"]) == (200, 0.92)
    assert wide["causes"] == {"slip": 11, "late step": 5}
    viable = found["groups"]["viable_survived"]
    assert (viable["n"], viable["upright"]) == (160, 150)
    assert viable["low"] == pytest.approx(0.8888, abs=1e-4)  # Wilson's, by hand
    assert viable["high"] == pytest.approx(0.9657, abs=1e-4)
    assert (found["runs"], found["sweeps"]) == (200, {"nominal": 1, "robustness": 1})
    assert found["made_with"] == {"study": made_by("robustness")["study"], **MADE_WITH}


def test_contacts_are_those_of_all_runs():
    good = rows_of("a", 2, 2, steps=50, false_contacts=1, missed_contacts=2)
    good[1] |= {"contact_latency": 4.0}
    fallen = rows_of("a", 0, 1, steps=10, false_contacts=9)
    met = rows_of("a", 1, 1, steps=10, missed_contacts=9, legs_met=3.0)
    assert contact_figures([*good, *fallen, *met]) == {
        "latency_ms": 2.0,
        "false_contact_rate": 11 / 120,
        "missed_contact_rate": 13 / 120,
        "swings": 120,
    }
    assert contact_figures([])["latency_ms"] is None


def test_tour_counts_the_pushes_before_the_fall(tmp_path):
    rows = rows_of("punch_tour", 3, 5, simulated=57.0)
    rows[2]["legs_met"] = 8.1
    for row, fall in zip(rows, (None, None, None, 5.9, 1.9), strict=True):
        row["sampled"] |= {f"pushes[{i}].time": 2.0 + 3.0 * i for i in range(18)}
        row["fall_time"] = fall
    assert [punches(row) for row in rows] == [(18, 18), (18, 18), (2, 18), (1, 18), (0, 18)]
    wide = write(tmp_path, "robustness", rows_of("wide", 200, 200))
    ran = [{**row, "group": "punch_tour_running"} for row in rows[2:4]]
    tour = write(tmp_path, "punch_tour", [*rows, *ran])
    found = write_robustness([wide, tour], tmp_path, "python -m studies.robustness")
    assert found["punches_running"] == [(2, 18), (1, 18)]
    assert (found["punches_survived"], found["runs"], found["duration_s"]) == (2.0, 200, 10.0)
    page = (tmp_path / "index.md").read_text()
    assert (
        "of 18, 5 runs\nsurvived 18, 18, 2, 1, 0;\nin a run of 1.5 m/s they survived 2, 1." in page
    )


def test_hardest_push_that_was_survived_is_named(tables, tmp_path):
    found = write_robustness(tables, tmp_path, "python -m studies.robustness")
    assert found["hardest_survived"] == {"impulse": 10.0 + 0.1 * 149, "index": 149}
    assert "survived had 24.9 N s:\nrun 149 of `wide_push`." in (tmp_path / "index.md").read_text()


def test_page_has_every_bar_its_pictures_and_its_runs(tables, tmp_path):
    tables = [table.rename(tmp_path / f"{i}.parquet") for i, table in enumerate(tables)]
    summary = write_robustness(tables, tmp_path, "python -m studies.robustness")
    page = (tmp_path / "index.md").read_text()
    for table, name in zip(tables, ("nominal.parquet", "robustness.parquet"), strict=True):
        assert f"[{name}]({name})" in page
        assert read_table(tmp_path / name) == read_table(table)
    for key in BARS:
        assert f"| `{key}` |" in page
    assert "any direction and phase, while commands change | 97.5 % |" in page
    assert "**NO**" in page and "undecided" in page
    assert "quick look" not in page
    assert "| slip -90 ms (left), late step -40 ms (70 mm, 20 ms) |" in page
    assert "| wide | 8000 |" in page
    assert "| wide | 199 of 200 | 0.12 m/s |" in page
    assert "| wide_push_15 | 11 | 5 | slip |" in page
    for picture in tmp_path.glob("*.png"):
        assert f"({picture.name})" in page
    assert page.count(".png)") == len(list(tmp_path.glob("*.png"))) == 8
    console = Console(width=120, record=True, file=io.StringIO())
    console.print(bar_table(summary["bars"]))
    assert "wide_push_10" in console.export_text()


def test_few_runs_are_called_a_quick_look(tmp_path):
    table = write(tmp_path, "nominal", rows_of("wide", 3, 3))
    write_robustness([table], tmp_path, "python -m studies.robustness --runs 3")
    page = (tmp_path / "index.md").read_text()
    assert "A quick look: 3 runs" in page
    assert "Every run was upright." in page


def test_two_tables_with_one_group_are_refused(tmp_path):
    tables = [write(tmp_path, name, rows_of("a", 1, 1)) for name in ("one", "two")]
    with pytest.raises(InputError, match="of another table"):
        write_robustness(tables, tmp_path, "")


def test_the_quick_form_walks_the_first_run_of_a_group(monkeypatch):
    group = quick.GROUPS[-1]
    monkeypatch.setattr(quick, "GROUPS", (group,))
    found = quick.probe()
    assert found.pop(f"{group}_upright") == (1.0, 0.0)
    ((name, error),) = found.items()
    assert name == f"{group}_speed_error_m_s"
    assert 0.0 < error.value < 0.5  # [m/s]: commands change all the time
    assert 0.0 < error.within < 0.1


@pytest.fixture
def quick_form(monkeypatch):
    """One that walks nothing: what it walks is tried above."""
    monkeypatch.setattr(command, "probe", lambda: {"upright": Probed(1.0, 0.0)})


@pytest.mark.usefixtures("quick_form")
def test_command_carries_out_sweeps_and_goes_on_with_them(tmp_path, capsys):
    file, out = write_sweep(tmp_path), tmp_path / "page"
    words = [str(file), "--out", str(out), "--sweeps", str(tmp_path / "sweeps")]
    words += ["--workers", "1"]
    assert main([*words, "--runs", "1"]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == str(out / "index.md")
    first = json.loads((out / "summary.json").read_text())
    assert (first["runs"], set(first["groups"])) == (1, {"low", "high"})
    assert first["command"] == f"python -m studies.robustness {file} --runs 1"
    assert first["probe"] == {"upright": [1.0, 0.0]}
    assert main([*words, "--runs", "2"]) == 0
    assert "2 runs were done before" in capsys.readouterr().out
    assert json.loads((out / "summary.json").read_text())["runs"] == 2
    assert main([*words, "--runs", "9"]) == 0
    assert json.loads((out / "summary.json").read_text())["runs"] == 4, "as many as the file says"


@pytest.mark.usefixtures("quick_form")
def test_published_runs_of_the_same_code_and_sweep_are_not_simulated_again(tmp_path, capsys):
    file, out = write_sweep(tmp_path, runs=2), tmp_path / "page"
    words = [str(file), "--out", str(out), "--workers", "1", "--sweeps"]
    assert main([*words, str(tmp_path / "here"), "--runs", "1"]) == 0
    first, *_ = read_table(table := out / "tiny.parquet")
    sweep, there = load_sweep(file), tmp_path / "journal_alone"
    assert [go_on_from(sweep, out, there), go_on_from(sweep, out, there)] == [2, 0]
    with open_journal(there, header_of(sweep), fresh=False) as journal:
        done = {key_of(row): row for row in journal.rows()}
    assert done == {key_of(row): row for row in first}
    capsys.readouterr()
    assert main([*words, str(tmp_path / "another_machine")]) == 0
    assert "2 runs of tiny are published already" in capsys.readouterr().out
    rows, units, about = read_table(table)
    assert [row for row in rows if row["index"] == 0] == first and len(rows) == 4
    assert go_on_from(replace(sweep, seed=2), out, tmp_path / "seed") == 0
    assert go_on_from(sweep, tmp_path / "none", tmp_path / "nowhere") == 0
    write_table(table, rows, units, {**about, "made_with": {**about["made_with"], "lab": "other"}})
    assert go_on_from(sweep, out, tmp_path / "unknown") == 0
    assert not (tmp_path / "seed").exists()
    table.write_bytes(b"[]")
    with pytest.raises(InputError, match="cannot be read"):
        go_on_from(sweep, out, tmp_path / "damaged")


@pytest.mark.usefixtures("quick_form")
def test_published_runs_of_other_code_hold_when_this_one_finds_the_same(tmp_path, capsys):
    file, out = write_sweep(tmp_path, runs=1), tmp_path / "page"
    words = [str(file), "--out", str(out), "--workers", "1", "--sweeps"]
    assert main([*words, str(tmp_path / "here")]) == 0
    rows, units, about = read_table(table := out / "tiny.parquet")
    sweep, made = load_sweep(file), {**about["made_with"], "lab": "other"}
    assert hold_over(sweep, out, 1) == 0, "this code made them"
    assert hold_over(sweep, tmp_path / "none", 1) == 0
    write_table(table, rows, units, {**about, "made_with": made})
    assert hold_over(replace(sweep, seed=2), out, 1) == 0
    capsys.readouterr()
    assert main([*words, str(tmp_path / "another_machine")]) == 0
    printed = capsys.readouterr().out
    assert "2 runs of other code hold" in printed and "2 runs of tiny are published" in printed
    assert read_table(table)[2] == about and read_table(table)[0] == rows
    rows[0]["roll_max"] = np.nextafter(rows[0]["roll_max"], 1.0)
    write_table(table, rows, units, {**about, "made_with": made})
    assert hold_over(sweep, out, 1) == 0
    assert read_table(table)[2]["made_with"] == made


def test_other_studies_take_walks_in_drake_from_what_is_published(monkeypatch):
    rows = [*rows_of("wide", 1, 1), *rows_of("wide_push_10", 0, 1)]
    rows[1] |= {"roll_max": 1.5, "fall_reason": "fell"}
    for module in (paired, walks):
        monkeypatch.setattr(
            module, "published_rows", lambda sweep: {key_of(row): row for row in rows}
        )
    draws = [draw for draw in paired.draws(2, paired.SIMULATORS) if draw.group == "wide"]
    (row,) = paired.known(draws).values()
    assert row == {
        "key": "wide 0 drake", "group": "wide", "index": 0, "how": "drake", "upright": True,
        "reason": "", "tilt": 0.1,
    }  # fmt: skip
    kinds = [walks.Walk(kind, i, on) for kind in walks.LOSSES for i in (0, 1) for on in (0, 1)]
    found = walks.known(kinds)
    assert {key: row["upright"] for key, row in found.items()} == {
        "wide 0 0 truth": True,
        "push_10 0 0 truth": False,
    }
    assert found["push_10 0 0 truth"]["reason"] == "fell"


def test_words_that_make_no_sense_are_refused(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    program = {"main": main, "name": "studies.robustness"}
    assert "none.yaml" in refuse(capsys, str(tmp_path / "none.yaml"), **program)
    assert "above 0" in refuse(capsys, "--runs", "0", **program)
    words = ("--workers", "1", "--scheduler", "tcp://x")
    assert "--scheduler" in refuse(capsys, *words, **program)
    assert list(tmp_path.iterdir()) == []


def test_published_numbers_are_those_of_the_published_runs():
    """Nobody has written a number into the page by hand, nor left a table of other runs there."""
    folder = Path(__file__).parents[3] / "docs" / "robustness"
    published = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    tables = [folder / f"{name}.parquet" for name in published["sweeps"]]
    assert sorted(folder.glob("*.parquet")) == sorted(tables)
    groups, _, abouts = read_tables(tables)
    summary = robustness_summary(groups, abouts, published["command"])
    found = json.loads(json.dumps(summary))
    found["made_with"] |= {"study": published["made_with"]["study"]}
    assert found == {key: published[key] for key in found}
