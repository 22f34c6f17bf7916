"""The study of running: its figures from made-up trials, what is resumed, and its scenarios."""

import json

import numpy as np
import pytest

from drake_linefoot.errors import InputError
from drake_linefoot.lab.results.provenance import made_with
from drake_linefoot.lab.scenario.load import validate
from studies.common.command import run
from studies.common.trials import kept
from studies.running.__main__ import running, summarize, write
from studies.running.cases import GROUPS, LADDERS, SEEDS, VARIANTS, WALKS, Trial, scenario, trials
from studies.running.jobs import missed, wanted
from studies.running.summary import BARS, bars, figures, groups, rungs, succeeded

GAIT = {
    "flights": 9,
    "flight_s": 0.05,
    "duty_factor": 0.35,
    "froude_number": 0.5,
    "cost_of_transport": 0.6,
    "cost_of_transport_absolute": 1.2,
    "torque_at_limit": 0.1,
}
WALKED = GAIT | {"flights": 0, "flight_s": None}


def row(case, label="", index=0, **changes):
    made = Trial(case, label, index)
    known = {"key": made.key, "case": case, "label": label, "index": index, "upright": True}
    known |= {"reason": "", "measured": [1.5, 0.0, 0.0], "gait": GAIT, "tilt": 0.1, "push": None}
    return known | {"stands": True, "state_hash": "abc"} | changes


def rows_of(name, share=1.0, **changes):
    """Every size of a ladder under every seed, each a share of what is commanded."""
    ladder, gait = LADDERS[name], WALKED if name == "walk_forward" else GAIT
    found = []
    for size in ladder.sizes:
        measured = ladder.command(size)
        measured[ladder.axis] = share * size
        told = {"measured": measured.tolist(), "gait": gait}
        found += [row(name, f"{size:g}", i, **told | changes) for i in range(SEEDS)]
    return found


def robot(name, share):
    return {"key": f"robot {name}", "case": "robot", "label": name, "speed": 2.5 * share,
            "share": share, "reason": ""}  # fmt: skip


def all_rows():
    found = [one for name in LADDERS for one in rows_of(name, 0.98)]
    found += [
        row(name, "", i, measured=[2.0, 0.0, 0.0]) for name, n in GROUPS.items() for i in range(n)
    ]
    found += [row("walk", name, measured=list(command)) for name, command in WALKS.items()]
    found += [row("pair", "wide", i) for i in range(4)]
    return found + [robot(str(i), 0.5 + 0.05 * i) for i in range(8)]


def test_every_bar_has_its_value():
    rows = all_rows()
    found = bars(figures(rows, {one["key"]: one for one in rows}), groups(rows))
    assert list(found) == list(BARS)
    values = {key: one["value"] for key, one in found.items()}
    assert values == pytest.approx({
        "walk_forward": 0.98 * 1.8, "run_forward": 0.98 * 2.6, "run_back": 0.98 * 1.4,
        "run_aside": 0.98 * 0.7, "run_turn": 0.98 * 1.2, "stand_run_stand": 20,
        "speed_error": 2.0, "run_push": 100.0, "run_rough": 100.0, "run_slope_5": 100.0,
        "run_on_estimate": 20, "zoo_share": np.mean([0.85, 0.8, 0.75, 0.7, 0.65, 0.6]),
        "walks": 0, "walks_paired": 0,
    })  # fmt: skip
    assert [key for key, one in found.items() if not one["met"]] == ["walk_forward", "zoo_share"]


def test_variants_are_compared_but_move_no_bar():
    """What is told of them is set, and they hold by their speed alone."""
    rows = [
        row(name, f"{size:g}", i, measured=[0.98 * size, 0.0, 0.0], gait=WALKED)
        for name, ladder in VARIANTS.items()
        for size in ladder.sizes
        for i in range(2)
    ]
    assert set(figures(rows, {}).values()) == {None}
    found = summarize(rows, {}, False)["variants"]
    assert {name: [one["size"] for one in some] for name, some in found.items()} == {
        name: list(ladder.sizes) for name, ladder in VARIANTS.items()
    }
    assert all(one["holds"] for some in found.values() for one in some)
    assert scenario(Trial("run_ecd", "2", 0)).mpc.model == "ecd"
    assert scenario(Trial("walk_quick_steps", "1.2", 0)).gait.double_support == 0.002


def test_what_was_not_tried_is_not_judged():
    assert {one["met"] for one in bars(figures([], {}), {}).values()} == {None}
    assert {
        one["met"] for one in bars(figures(all_rows(), {}), groups(all_rows()), quick=True).values()
    } == {None}


@pytest.mark.parametrize(
    "changes",
    [
        {"upright": False},
        {"gait": GAIT | {"flight_s": 0.03}},
        {"gait": WALKED},
        {"gait": None, "measured": None},
        {"tilt": 0.3},
        {"measured": [1.9, 0.0, 0.0]},
        {"measured": [2.2, 0.2, 0.0]},
    ],
)
def test_one_seed_that_does_not_run_as_asked_is_enough(changes):
    rows = rows_of("run_forward")
    for one in rows:
        if float(one["label"]) > 2.1 and one["index"] == 3:
            one.update(changes)
    assert figures(rows, {})["run_forward"] == pytest.approx(2.0)
    assert [rung["holds"] for rung in rungs(rows, "run_forward")] == [True] * 3 + [False] * 4


def test_a_walk_must_not_fly_nor_be_at_its_limits():
    for bad in ({"flights": 1, "flight_s": 0.02}, {"torque_at_limit": 0.16}):
        rows = rows_of("walk_forward")
        for one in rows:
            if float(one["label"]) > 1.45:
                one["gait"] = WALKED | bad
        assert figures(rows, {})["walk_forward"] == pytest.approx(1.4)


def test_a_backward_run_counts_by_its_size():
    rows = [one for one in rows_of("run_back") if float(one["label"]) > -1.3]
    assert figures(rows, {})["run_back"] == pytest.approx(1.2)


def test_what_counts_as_a_success():
    assert succeeded(row("run_push"))
    assert not succeeded(row("run_push", upright=False))
    assert succeeded(row("run_rough", measured=[1.21, 0.0, 0.0]))
    assert not succeeded(row("run_rough", measured=[1.19, 0.0, 0.0]))
    assert succeeded(row("stand_run_stand", measured=[1.91, 0.0, 0.0]))
    for changes in ({"stands": False}, {"measured": None}, {"measured": [1.8, 0.0, 0.0]}):
        assert not succeeded(row("stand_run_stand", **{"measured": [2.0, 0.0, 0.0]} | changes))
    assert not succeeded(row("run_on_estimate", gait=WALKED))
    rows = [row("run_slope_5", "", i, upright=i > 0, reason="fell" * (i == 0)) for i in range(4)]
    found = groups(rows)["run_slope_5"]
    assert (found["runs"], found["succeeded"], found["falls"]) == (4, 3, [[0, "fell"]])


def test_walks_are_compared_with_those_of_before_one_by_one():
    rows = [row("walk", "0.4", i) for i in range(3)] + [
        row("pair", g, i) for g in "ab" for i in (0, 1)
    ]
    before = {one["key"]: dict(one) for one in rows}
    before[rows[1]["key"]] |= {"state_hash": "other", "tilt": 0.1001}
    before[rows[2]["key"]] |= {"state_hash": "of another processor", "tilt": 0.1 + 1e-12}
    before[rows[3]["key"]]["upright"] = False  # better now
    rows[5] = rows[5] | {"upright": False}  # worse now
    found = figures(rows, before)
    assert (found["walks"], found["walks_paired"]) == (1, 1)
    before[rows[0]["key"]]["upright"] = False  # with the same figures
    assert figures(rows, before)["walks"] == 2


def test_page_pictures_and_summary(tmp_path):
    rows = all_rows()
    rows[-20] = row(
        "run_push", "", 99, push=[1.0, 5.1], upright=False, reason="fell", measured=None
    )
    curves = {"time": [0.0, 0.1, 0.2], "force": [[0.0, 9.0]] * 3, "height": [0.6] * 3}
    rows.append(row("run_ecd", "2"))
    rows.append(row("picture", curves=curves | {"speed": [2.0] * 3, "flights": [[0.1, 0.15]]}))
    write(tmp_path, summarize(rows, {}, False), rows)
    page = (tmp_path / "index.md").read_text()
    assert all(f"`{key}`" in page for key in BARS)
    tried = [ladder.what in page for ladder in VARIANTS.values()]
    assert tried == [name == "run_ecd" for name in VARIANTS]  # what was not tried has no table
    assert "A quick look" not in page
    for name in ("speeds.png", "run.png", "pushes.png"):
        assert f"({name})" in page
        assert (tmp_path / name).read_bytes().startswith(b"\x89PNG")
    assert json.loads((tmp_path / "summary.json").read_text())["bars"]["run_forward"]["met"]


def test_a_study_goes_on_with_what_the_same_code_found(tmp_path):
    file, one = tmp_path / "done.jsonl", row("walk", "0.4")
    assert kept(file) == {}
    file.write_text("\n".join(map(json.dumps, [made_with(), one])) + '\n{"key": "half')
    assert kept(file, made_with()) == {one["key"]: one}
    assert kept(file, {**made_with(), "controller": "other"}) == {}
    assert kept(file) == {one["key"]: one}


def test_a_study_of_what_is_done_writes_its_page_alone(tmp_path, capsys):
    jobs = wanted(True, ["walk", "robot"])
    rows = [missed(job, "lost") | {"index": 0} for job in jobs]
    (tmp_path / "trials.jsonl").write_text("\n".join(map(json.dumps, [made_with(), *rows])) + "\n")
    words = ["--quick", "--out", tmp_path, "--case", "walk"]
    assert run(running, "running", [*map(str, words), "--case", "robot"]) == 0
    assert f"{len(jobs)} of {len(jobs)} trials were found before" in capsys.readouterr().out
    assert (tmp_path / "index.md").exists()


def test_a_case_that_there_is_not_is_refused():
    with pytest.raises(InputError, match="must be one of"):
        wanted(False, ["hop"])


def test_trials_differ_and_their_scenarios_can_be_run():
    every = list(trials(False))
    assert len({one.key for one in every}) == len(every)
    assert {len([t for t in every if t.case == name]) for name in ("run_push", "run_rough")} == {
        100
    }
    pushes = [scenario(one).pushes[0] for one in every if one.case == "run_push"]
    assert np.ptp([push.direction for push in pushes]) > 6.0
    assert 5.0 <= min(push.time for push in pushes) <= max(push.time for push in pushes) <= 5.34
    assert {push.impulse for push in pushes} == {10.0}
    slopes = {scenario(one).ground.slope_heading for one in every if one.case == "run_slope_5"}
    assert slopes == {0.0, np.pi}
    for case in dict.fromkeys(one.case for one in every):
        made = scenario(next(one for one in every if one.case == case))
        validate(made, case)
        assert made.estimation == (case == "run_on_estimate")
