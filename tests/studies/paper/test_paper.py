"""`python -m studies.paper`: what it computes again, what it writes, and how it ends."""

import io
import json
from dataclasses import asdict

import numpy as np
import pytest
from rich.console import Console

from drake_linefoot.errors import LinefootError, OutputError
from studies.common.command import run
from studies.common.files import write_text
from studies.paper import __main__ as paper
from studies.paper import compute, fig5, fig6
from studies.paper.figure import Claim
from tests.helpers.command_line import refuse
from tests.helpers.made_up import walk


def main(arguments):
    return run(paper.paper, "paper", arguments)


FORECAST = paper.FORECAST
RATIOS = {
    "roll_rms_ecd_over_srbm": 0.5,
    "pitch_rms_ecd_over_srbm": 0.25,
    "roll_rms_cc_over_ecd": 0.7,
    "pitch_rms_cc_over_ecd": 0.4,
}
RATIOS = {
    **RATIOS,
    **{f"{name}_interval": [0.3, 0.8] for name in RATIOS},
    **{f"{name}_pooled": 0.4 for name in RATIOS},
    "statistic": "the mean <of> ratios",
}


@pytest.fixture
def computed(monkeypatch):
    """Names of figures that were computed; their data are those of a walk made by hand."""
    names = []
    made = {"fig5": fig5.measure, "fig6": fig6.measure}

    def run(missing, quick, out, made_with, console):
        for name in missing:
            names.append(name)
            stored = {
                "figure": name,
                "made_with": made_with,
                "seconds": 1.0,
                "data": made[name](walk()),
            }
            write_text(out / f"{name}.json", json.dumps(stored))

    monkeypatch.setattr(compute, "run", run)
    monkeypatch.setattr(paper, "FIGURES", ("fig5", "fig6"))
    return names


def write(out, figure=None, quick=True, fresh=False):
    words = [*([figure] if figure else []), "--out", str(out)]
    return main([*words, *(["--quick"] if quick else []), *(["--fresh"] if fresh else [])])


# ------------------------------------------------------------------------------- resuming


def test_what_is_there_is_not_computed_again(tmp_path, computed):
    out = tmp_path / "deep" / "out"
    assert write(out, "fig5") == 0
    assert computed == ["fig5"]
    write(out)
    assert computed == ["fig5", "fig6"]
    write(out)
    assert computed == ["fig5", "fig6"]


def test_fresh_computes_all_again(tmp_path, computed):
    write(tmp_path)
    write(tmp_path, fresh=True)
    assert computed == ["fig5", "fig6"] * 2


def test_another_length_other_code_or_a_broken_file_is_computed_again(
    tmp_path, computed, monkeypatch
):
    write(tmp_path, "fig5")
    write(tmp_path, "fig5", quick=False)
    assert computed == ["fig5"] * 2
    monkeypatch.setattr(paper, "made_with", lambda: {"controller": "other"})
    write(tmp_path, "fig5", quick=False)
    assert computed == ["fig5"] * 3
    (tmp_path / "fig5.json").write_text('{"figure": "fig5"', encoding="utf-8")
    write(tmp_path, "fig5", quick=False)
    assert computed == ["fig5"] * 4


def test_another_scenario_is_computed_again(tmp_path):
    made_with = paper.stamp(True)
    stored = {"figure": "fig5", "made_with": made_with, "seconds": 1.0, "data": {}}
    write_text(tmp_path / "fig5.json", json.dumps(stored))
    assert paper.read(tmp_path, "fig5", made_with) is not None
    other = {**made_with, "scenario": made_with["scenario"].replace("seed: 0", "seed: 1")}
    assert other != made_with
    assert paper.read(tmp_path, "fig5", other) is None
    assert paper.read(tmp_path, "fig6", made_with) is None


# ------------------------------------------------------------------------------ what is written


def test_files(tmp_path, computed, capsys):
    write(tmp_path)
    printed = capsys.readouterr().out
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {
        "fig5.json",
        "fig5.png",
        "fig6.json",
        "fig6.png",
        "claims.json",
        "index.html",
    }
    summary = json.loads((tmp_path / "claims.json").read_text(encoding="utf-8"))
    assert set(summary) == {
        "made_with",
        "seconds",
        "probe",
        "quick",
        *RATIOS,
        "ratios_from",
        "claims",
        FORECAST,
    }
    assert summary["roll_rms_ecd_over_srbm"] is summary[FORECAST] is None
    for claim in summary["claims"]:
        assert set(claim) == {"figure", "claim", "paper", "ours", "holds", "note"}
        assert claim["holds"] in (True, False, None)
    assert {claim["figure"] for claim in summary["claims"]} == {"fig5", "fig6"}
    vanishes, perfect = (asdict(claim) for claim in fig5.claims(fig5.measure(walk())))
    assert summary["claims"][:2] == [{"figure": "fig5", **vanishes}, {"figure": "fig5", **perfect}]
    text = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert text.count("data:image/png;base64,") == 2
    assert "src=" not in text.replace('src="data:', "")  # nothing outside is needed
    assert "name: paper" not in text  # the scenario of the run itself is what is shown
    assert "vanishes" in text
    assert "vanishes" in printed


def test_one_figure_keeps_the_others_on_the_page(tmp_path, computed, capsys):
    write(tmp_path)
    capsys.readouterr()
    write(tmp_path, "fig6")
    assert "fig5" not in capsys.readouterr().out
    assert (tmp_path / "index.html").read_text(encoding="utf-8").count("<img") == 2


def test_ratios_are_the_grid_s_when_there_is_one():
    fig4 = {"fig4": {"data": {"ratios": RATIOS}}}
    grid = {"grid": {"data": {"ratios": dict.fromkeys(RATIOS, 0.6)}}}
    assert paper.ratios(fig4) == (RATIOS, "fig4")
    assert paper.ratios(fig4 | grid) == (dict.fromkeys(RATIOS, 0.6), "grid")
    assert paper.ratios({"fig4": {"data": {"ratios": {}}}}) == (dict.fromkeys(RATIOS), None)
    assert paper.ratios({"grid": {"data": dict(RATIOS)}}) == (RATIOS, "grid")


def test_page_escapes_and_says_what_fell():
    claim = Claim("a < b", "<i>", "1 & 2", False)
    data = {"scenario": "a: <b>", "seeds": [0], "fell": True, "fall_reason": "torso low"}
    section = paper.Section("fig5", "T <t>", b"png", [["x"], ["<y>"]], [claim], data, 1.0)
    summary = {"made_with": {"controller": "1"}, "quick": True, **RATIOS, "ratios_from": "fig4"}
    text = paper.html([section], summary)
    assert "0 of 1 claims hold here" in text
    assert "A run FELL: torso low" in text
    assert "roll 0.50, pitch 0.25" in text
    assert "<p>the mean &lt;of&gt; ratios." in text
    for raw in ("<t>", "<y>", "<b>", "<i>", "a < b"):
        assert raw not in text


def test_page_answers_each_figure_of_the_paper_before_its_picture_and_folds_the_rest():
    figures = {*paper.FIGURES, "fig2"} & {f"fig{k}" for k in range(2, 8)}
    assert set(paper.ANSWERS) == figures
    claims = [Claim(f"claim {k}", "", f"found {k}", True) for k in range(5)]
    about = b"png", [["x"], ["a cell"]], claims, {"scenario": "a: b"}, 1.0
    sections = [paper.Section(name, "a title", *about) for name in ("grid", "fig7")]
    summary = {"made_with": {"controller": "1"}, "quick": True, **RATIOS, "ratios_from": "fig4"}
    text = paper.html(sections, summary)
    said = "median error of found 0."
    order = ["10 of 10 claims hold here", said, "<img", "<details", "a cell", "Beyond them"]
    assert [text.index(part) for part in order] == sorted(text.index(part) for part in order)
    assert text.count(said) == 1


def test_a_file_that_cannot_be_written_is_told(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(OutputError):
        paper.prepare(tmp_path / "file" / "out")


# -------------------------------------------------------------------------------- workers


def test_figures_of_one_walk_share_a_process_and_times_are_taken_alone():
    names = ["fig2", "fig3", "fig4", "grid", "fig5", "fig6"]
    side_by_side, alone = compute.batches(names)
    assert side_by_side == [["grid"], ["fig4"], ["fig3", "fig5", "fig6"]]
    assert alone == [["fig2"]]
    assert compute.batches(["fig4"]) == ([["fig4"]], [])


def test_a_figure_that_cannot_be_computed_is_told(tmp_path):
    console = Console(file=io.StringIO())
    with pytest.raises(LinefootError, match="nowhere: InputError: figure = 'nowhere'"):
        compute.run(["nowhere"], True, tmp_path, {}, console)
    assert list(tmp_path.iterdir()) == []


# --------------------------------------------------------------------------- command line


def test_unknown_figure_is_refused_before_anything_is_written(tmp_path, capsys):
    words = ("fig1", "--out", str(tmp_path / "out"))
    said = refuse(capsys, *words, main=main, name="studies.paper")
    assert "figure = 'fig1': unknown; must be one of [" in said
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(("fell", "status"), [(False, 0), (True, 1)])
def test_exit_status(capsys, tmp_path, computed, monkeypatch, fell, status):
    measure = fig5.measure
    monkeypatch.setattr(fig5, "measure", lambda run: {**measure(run), "fell": fell})
    monkeypatch.setattr(paper, "read", _with(fell, paper.read))
    assert main(["--quick", "--out", str(tmp_path)]) == status
    assert capsys.readouterr().out.rstrip().endswith("index.html")


def _with(fell, read):
    def changed(out, name, made_with):
        result = read(out, name, made_with)
        if result is not None:
            result["data"].update(fell=fell, fall_time=1.0, fall_reason="torso low")
        return result

    return changed


@pytest.mark.slow
def test_one_quick_figure_end_to_end(capsys, tmp_path):
    assert main(["fig5", "--quick", "--out", str(tmp_path)]) == 0
    assert capsys.readouterr().err == ""
    stored = json.loads((tmp_path / "fig5.json").read_text(encoding="utf-8"))
    assert stored["made_with"] == paper.stamp(True)
    assert "name: paper" in stored["data"]["scenario"]
    assert stored["data"]["seeds"] == [0]
    summary = json.loads((tmp_path / "claims.json").read_text(encoding="utf-8"))
    vanishes = stored["data"]["zero_after"] >= 0.95 > stored["data"]["zero_before"]
    assert [claim["holds"] for claim in summary["claims"]] == [vanishes, True]
    assert np.median(stored["data"]["force"]) < 1.0
    assert (tmp_path / "fig5.png").read_bytes()[:4] == b"\x89PNG"
