"""Published results: of which code they are, whether their studies would say the same today."""

import json

import pytest

from drake_linefoot.lab.results.provenance import CONTROLLER, LAB
from drake_linefoot.lab.sweep.table import read_table
from studies.common import stamp
from studies.common.command import BAD_INPUT, BROKE_OFF, DOCS, FINE, run
from studies.common.stamp import Probed, disagreements, made_by, stamped
from studies.publish import __main__ as publish
from studies.publish import standing as judging
from studies.publish.page import PAGE, asked_of, claim_rows, page_of
from studies.publish.results import RESULTS, Result
from studies.publish.standing import State, cheapest_first, probe_of, standing

ONE = Result("one", "It is one.", "running", "one.json", "one.md", "running.probe:probe")
CODE = (CONTROLLER, LAB)
FOUND = {"speed": Probed(2.0, 0.1), "upright": Probed(1.0, 0.0)}


@pytest.fixture
def docs(tmp_path, monkeypatch):
    """A folder of documents with one result of today's code, whose probe finds `FOUND`."""
    monkeypatch.setattr(judging, "DOCS", tmp_path)
    monkeypatch.setattr(publish, "DOCS", tmp_path)
    monkeypatch.setattr(publish, "RESULTS", (ONE,))
    monkeypatch.setattr(publish, "page_of", lambda results: f"page of {len(results)}")
    monkeypatch.setattr(judging, "probe_of", lambda result: lambda: FOUND)
    write(tmp_path)
    return tmp_path


def write(folder, probe=FOUND, page=None, **changes):
    """Write a result; `changes` are of what it was made with."""
    data = stamped("running", 7200.0, lambda: probe)
    data["made_with"] = {**data["made_with"], **changes}
    (folder / ONE.data).write_text(json.dumps(data))
    text = " ".join(data["made_with"].values()) if page is None else page
    (folder / ONE.page).write_text(f"by {text}")


def test_a_result_of_this_code_is_fresh(docs):
    found = standing(ONE)
    assert (found.state, found.why, found.seconds) == (State.FRESH, "", 7200.0)


@pytest.mark.parametrize("digest", ["controller", "lab", "study"])
def test_a_result_of_other_code_stands_while_its_quick_form_agrees(docs, digest):
    write(docs, {**FOUND, "speed": Probed(1.95, 0.1)}, **{digest: "other"})
    assert standing(ONE).state == State.AGREES
    assert standing(ONE, quick_forms=False).state == State.STALE
    write(docs, {**FOUND, "speed": Probed(1.8, 0.1)}, **{digest: "other"})
    found = standing(ONE)
    assert found.state == State.STALE
    assert "speed is 2, was 1.8 +- 0.1" in found.why and f"{digest} other instead of" in found.why


def test_a_result_that_cannot_be_checked_is_to_be_made_again(docs):
    write(docs, {}, controller="other")
    assert "no quick form" in standing(ONE).why and standing(ONE).state == State.STALE
    for digest in judging.DIGESTS:
        one = {name: value for name, value in made_by("running").items() if name != digest}
        write(docs, page=" ".join(one.values()))
        assert standing(ONE).why == "one.md is not of one.json"
    data = json.loads((docs / ONE.data).read_text())
    del data["made_with"]["study"]
    (docs / ONE.data).write_text(json.dumps(data))
    assert standing(ONE).why == "it does not say which study made it"
    (docs / ONE.page).unlink()
    assert standing(ONE).state == State.STALE and "cannot be read" in standing(ONE).why


def test_numbers_of_a_machine_are_not_compared(docs):
    write(docs, controller="other")
    of_a_machine = Result("one", "It is one.", "running", "one.json", "one.md")
    assert standing(of_a_machine).state == State.OF_A_MACHINE


def test_numbers_that_are_no_numbers_or_come_and_go_disagree():
    stored = {"a": [1.0, 0.1], "b": [float("nan"), 1.0], "c": [0.0, 0.0]}
    now = {"a": Probed(1.05, 9.0), "b": Probed(0.0, 1.0), "d": Probed(0.0, 1.0)}
    found = disagreements(stored, lambda: now)
    assert [words.split()[0] for words in found] == ["b", "c", "d"]


def test_what_took_least_comes_first(docs):
    known, unknown = standing(ONE), judging.Standing(ONE, State.STALE)
    quick = judging.Standing(ONE, State.STALE, seconds=1.0)
    assert cheapest_first([unknown, known, quick]) == [quick, known, unknown]


def test_checking_fails_where_something_is_to_be_made_again(docs, capsys):
    assert run(publish.publish, "publish", ["--check"]) == FINE
    write(docs, {}, controller="other")
    assert run(publish.publish, "publish", ["--check"]) == BROKE_OFF
    shown = capsys.readouterr().out
    assert "to be made again" in shown and "2.00" in shown
    assert run(publish.publish, "publish", ["two", "--check"]) == BAD_INPUT
    assert "must be one of ['one']" in capsys.readouterr().err


def test_what_is_of_other_code_is_made_again(docs, monkeypatch):
    made = []
    monkeypatch.setattr(publish, "make", lambda result: made.append(result.target))
    assert run(publish.publish, "publish", []) == FINE and made == []
    write(docs, controller="other")
    assert run(publish.publish, "publish", ["--stale"]) == FINE and made == []
    assert run(publish.publish, "publish", []) == FINE and made == ["one"]
    assert (docs / PAGE).read_text() == "page of 1"


def test_a_study_is_not_given_the_words_of_publish(docs, monkeypatch):
    """What a make was told on its command line it would tell those that it begins."""
    begun = []

    def begin(words, check):
        begun.append(words)
        return type("", (), {"returncode": 0})

    monkeypatch.setattr(publish.subprocess, "run", begin)
    publish.make(ONE)
    assert begun == [["make", "--no-print-directory", "one", "ARGS="]]


def test_a_study_that_fails_publishes_nothing(docs, monkeypatch, capsys):
    write(docs, controller="other")
    monkeypatch.setattr(publish.subprocess, "run", lambda *_, **__: type("", (), {"returncode": 2}))
    assert run(publish.publish, "publish", []) == BROKE_OFF
    assert "make one ended with status 2" in capsys.readouterr().err


def test_what_a_study_wrote_elsewhere_is_copied(docs, tmp_path, monkeypatch):
    out = tmp_path / "out"
    (out / "paper").mkdir(parents=True)
    for name in ("one.json", "a.png", "b.png", "other.json"):
        (out / "paper" / name).write_text(name)
    monkeypatch.setattr(publish, "OUT", out)
    publish.copy(
        Result("one", "It is one.", "running", "one.json", "one.md", "", "paper", ("*.png",))
    )
    assert (docs / "one.json").read_text() == "one.json" and (docs / "b.png").exists()
    assert not (docs / "other.json").exists()


def test_every_result_is_there_with_a_study_and_a_quick_form():
    assert len({one.target for one in RESULTS}) == len(RESULTS)
    for one in RESULTS:
        assert (DOCS / one.data).exists() and (DOCS / one.page).exists()
        assert made_by(one.study)["study"]
        if one.probe:
            assert callable(probe_of(one))


def test_all_data_that_is_published_is_of_a_result_and_says_what_made_it():
    """Runs and trials that are kept beside the numbers are of the code that the numbers are of."""
    data = {one.data: json.loads((DOCS / one.data).read_text()) for one in RESULTS}
    assert data.keys() == {path.relative_to(DOCS).as_posix() for path in DOCS.rglob("*.json")}
    made = {name: one["made_with"] for name, one in data.items()}
    assert all(set(judging.DIGESTS) <= set(one) for one in made.values())
    told = {path: read_table(path)[2]["made_with"] for path in DOCS.rglob("*.parquet")}
    for path in DOCS.rglob("*.jsonl"):
        with path.open(encoding="utf-8") as lines:
            told[path] = json.loads(next(lines))
    for path, by in told.items():
        if path.name != "before.jsonl":  # of a gait that is gone, to compare with
            beside = [one for name, one in made.items() if (DOCS / name).parent == path.parent]
            assert any(all(by[key] == one[key] for key in CODE) for one in beside), path


def test_a_digest_is_of_one_study_and_of_what_all_share(tmp_path, monkeypatch):
    for name in ("running", "common", "ground"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "a.py").write_text(name)
    monkeypatch.setattr(stamp, "STUDIES", tmp_path)

    def found():
        made_by.cache_clear()
        return made_by("running.part")["study"]

    first = found()
    (tmp_path / "ground" / "a.py").write_text("other")
    assert found() == first
    (tmp_path / "common" / "a.py").write_text("other")
    assert found() != first
    with pytest.raises(ValueError, match="no study 'none'"):
        made_by("none")
    made_by.cache_clear()


def test_the_page_is_that_of_the_published_results():
    page = page_of(RESULTS)
    assert page == (DOCS / PAGE).read_text(encoding="utf-8")
    for one in RESULTS:
        assert f"| {one.claim} |" in page and f"`make {one.target}`" in page
    assert len(page.split("## Every bar")[1].splitlines()) > 100


def test_what_has_no_bar_is_left_out():
    bars = {"a": {"value": 1.0, "bar": 2.0}, "b": {"value": 1.0, "bar": None}}
    assert list(asked_of({"bars": bars})) == ["a"]
    assert asked_of({}) == {}


def test_what_is_asked_of_a_claim_is_what_the_paper_says():
    claim = {
        "figure": "fig2",
        "claim": "|r| is less",
        "paper": "20 %",
        "ours": "9 %",
        "holds": None,
    }
    assert claim_rows([claim]) == [["fig2", "/r/ is less", "9 %", "-", "20 %", "undecided"]]
