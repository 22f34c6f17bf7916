"""The envelope: bisection, what counts as tracked, and what is said to have stopped a walk."""

import json
from copy import deepcopy
from dataclasses import asdict

import numpy as np
import pytest

from drake_linefoot.errors import OutputError
from drake_linefoot.lab.scenario.load import validate
from studies.common.command import run
from studies.common.runs import paper_scenario
from studies.envelope import __main__ as command
from studies.envelope import envelope
from studies.envelope.bisection import bisect, largest
from studies.envelope.envelope import Walks, draw, summary
from studies.envelope.walks import AXES, Attempt, attempted, lost, reason, tracked, unlimited
from studies.paper import __main__ as paper
from tests.helpers.recorded_runs import make_run

TIME = np.arange(4001) * 1e-3


def up_to(limit, tried):
    """An attempt that holds up to a size."""

    def attempt(size):
        tried.append(size)
        return size <= limit, f"at {size:g}"

    return attempt


@pytest.mark.parametrize("limit", [0.03, 0.31, 0.8, 1.29, 1.3, 1.62, 2.44])
def test_the_bisection_brackets_the_limit(limit):
    tried = []
    found = bisect(up_to(limit, tried), 1.3, 2.5, 0.05)
    low = found.best[0] if found.best else 0.0
    assert low <= limit < found.failed[0]
    assert found.failed[0] - low <= 0.05 * (1 + 1e-9)
    assert tried[0] == 1.3
    assert len(tried) == len(set(tried)) <= 7


def test_the_bisection_stops_at_the_end_when_all_holds():
    found = bisect(up_to(9.0, []), 1.3, 2.5, 0.05)
    assert found.failed is None
    assert 2.45 <= found.best[0] <= 2.5
    assert found.best[1] == f"at {found.best[0]:g}"


def test_what_the_first_seeds_find_must_hold_with_all():
    """Seed 3 walks less than the others."""
    limits = {0: 1.7, 1: 1.62, 2: 1.9, 3: 1.41, 4: 1.8}
    tried = []

    def attempt(size, seeds):
        tried.append((size, tuple(seeds)))
        return all(size <= limits[seed] for seed in seeds), [f"{size:g} {s}" for s in seeds]

    found = largest(attempt, (0, 1, 2, 3, 4), 1.3, 2.5, 0.05)
    assert 1.36 <= found.best[0] <= 1.41 < found.failed[0] <= 1.46
    assert [row.split()[1] for row in found.best[1]] == ["0", "1", "2", "3", "4"]
    assert len(tried) == len(set(tried))


def test_the_bisection_says_when_nothing_holds():
    found = bisect(up_to(0.0, []), 1.0, 2.0, 0.1)
    assert found.best is None
    assert found.failed[0] == pytest.approx(0.1)


def test_a_command_is_tracked_within_a_tenth_or_the_least():
    assert tracked((1.0, 0.0, 0.0), [0.91, 0.04, -0.04])
    assert not tracked((1.0, 0.0, 0.0), [0.89, 0.0, 0.0])
    assert not tracked((1.0, 0.0, 0.0), [1.0, 0.06, 0.0])
    assert tracked((0.0, 0.0, 2.0), [0.0, 0.0, 1.81])
    assert not tracked((0.0, 0.0, 2.0), None)


def test_commands_of_the_axes():
    assert AXES["backward"].command(0.8) == (-0.8, 0.0, 0.0)
    assert AXES["forward_and_turning"].command(0.6) == (0.8, 0.0, 0.6)


def test_no_command_of_an_axis_is_clipped():
    scenario = unlimited(paper_scenario(False))
    validate(scenario)
    for axis in AXES.values():
        limits = [scenario.gait.forward_max, scenario.gait.lateral_max, scenario.gait.turn_max]
        assert np.all(np.abs(axis.command(axis.end)) <= limits)


# --- what stopped it -----------------------------------------------------------------------------


def still(humanoid, **channels):
    q = np.tile(humanoid.q_nominal, (len(TIME), 1))
    run = make_run(TIME, **{"q": q, **channels})
    run.scenario.segments[-1].velocity, run.scenario.segments[-1].turn_rate = [1.0, 0.0], 0.5
    return run


def at_its_stop(run, humanoid, samples):
    """Put the left ankle at its lower stop."""
    ankle = list(humanoid.description.actuated_joints).index("left_ankle")
    run.q[samples, humanoid.actuated_q[ankle]] = humanoid.position_lower[ankle]


def test_tracking_is_named_with_its_error(humanoid):
    said = reason(still(humanoid), [0.8, 0.0, 0.49])
    assert said == "tracking: forward speed off by -0.20"


def test_what_was_seen_while_the_command_was_not_followed_is_named(humanoid):
    run = still(humanoid)
    at_its_stop(run, humanoid, slice(100, 200))  # in the first half, which does not count
    assert "joint limit" not in reason(run, [1.0, 0.2, 0.5])
    at_its_stop(run, humanoid, slice(3200, 3300))
    said = reason(run, [1.0, 0.2, 0.5])
    assert said == "tracking: sideways speed off by +0.20; before: joint limit"


def test_the_limits_before_a_fall_are_named(humanoid):
    run = still(humanoid, fell=True)
    at_its_stop(run, humanoid, slice(3650, 3800))
    run.clipped_torques[3400:3500] = 1.0
    said = reason(run, None)
    expected = "fell at 4.00 s: torso low; before: joint limit, torques cut in 10 % of the ticks"
    assert said == expected


def test_the_fall_itself_is_no_sign(humanoid):
    run = still(humanoid, fell=True)
    run.q[3800:, :4] = [np.cos(0.2), np.sin(0.2), 0.0, 0.0]  # tilted, for good
    run.clipped_torques[3800:] = 1.0
    at_its_stop(run, humanoid, slice(3850, 4001))
    assert reason(run, None) == "fell at 4.00 s: torso low"


# --- the whole of it -----------------------------------------------------------------------------


def row(size, held, measured=None, why=""):
    seen = {"measured": measured, "held": held, "stopped_by": why}
    return {"seed": 0, "command": [size, 0, 0], **seen, "at_limit": {"knee": 0.1 * size}}


def test_the_summary_takes_the_worst_seed_and_the_first_failure():
    rows = [row(1.3, True, [1.3, 0.0, 0.0]), row(1.3, True, [1.2, 0.0, 0.0])]
    bad = [row(1.35, True, [1.3, 0, 0]), row(1.35, False, None, "fell")]
    one = summary(AXES["forward"], envelope.Found((1.3, rows), (1.35, bad)))
    assert one["size"] == 1.3
    assert one["measured"] == [1.2, 0.0, 0.0]
    assert one["at_limit"] == {"knee": pytest.approx(0.13)}
    assert one["stopped_by"] == "fell"
    assert one["stopped_at"] == [1.35, 0.0, 0.0]
    nothing = summary(AXES["forward"], envelope.Found(None, (0.05, bad)))
    assert nothing["command"] is None


def fake_measure(models, chosen, quick, report, _):
    report("ecd, forward 1: walked")
    best = envelope.Found((1.5, [row(1.5, True, [1.5, 0.0, 0.0])]), None)
    axes = {name: summary(AXES[name], best) for name in chosen}
    about = {"quick": quick, "duration": 6.0, "seeds": [0], "scenario": "name: made_up"}
    yield {**about, "seconds": 1.0, "models": {model: axes for model in models}}


def test_it_writes_both_files_and_a_table(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(command, "measure", fake_measure)
    monkeypatch.setattr(command, "probe", dict)
    monkeypatch.setattr(command, "DONE", tmp_path / "envelope.jsonl")
    words = ["--out", str(out := tmp_path / "deep" / "out"), "--model", "ecd"]
    assert run(command.envelope, "envelope", [*words, "--model", "contact_consistent"]) == 0
    data = json.loads((out / "envelope.json").read_text())
    assert list(data["models"]) == ["ecd", "contact_consistent"]
    assert set(data["models"]["ecd"]) == set(AXES)
    assert (out / "envelope.png").stat().st_size > 1000
    assert "turning in place" in capsys.readouterr().out
    assert len(draw(data).axes[0].patches) == 2 * len(AXES)
    made_with = {"made_with": {}, "quick": True, "scenario": ""}
    paper.report({}, [], out, made_with)
    page = (out / "index.html").read_text(encoding="utf-8")
    assert 'id="envelope"' in page
    assert "turning in place (rad/s)" in page
    assert page.count("data:image/png;base64,") == 1


def test_only_the_axes_that_are_asked_for_are_drawn(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(command, "measure", fake_measure)
    monkeypatch.setattr(command, "probe", dict)
    words = ["--out", str(tmp_path), "--quick", "--axis", "turning", "--axis", "backward"]
    assert run(command.envelope, "envelope", words) == 0
    data = json.loads((tmp_path / "envelope.json").read_text())
    assert set(data["models"]["ecd"]) == {"turning", "backward"}
    ax = draw(data).axes[0]
    titles = [label.get_text() for label in ax.get_yticklabels()]
    assert titles == ["backward [m/s], aim 1.4", "turning in place [rad/s], aim 2"]
    assert len(ax.patches) == 2 * 2
    shown = capsys.readouterr().out
    assert "backward (m/s)" in shown
    assert "sideways" not in shown


@pytest.mark.parametrize("words", [["--model", "rigid"], ["--axis", "rigid"]])
def test_a_model_or_an_axis_that_there_is_not_is_refused(tmp_path, capsys, words):
    words = ["--out", str(tmp_path / "out"), *words]
    assert run(command.envelope, "envelope", words) == 2
    assert "'rigid' must be one of" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def up_to_one(job):
    held = bool(np.abs(job.command).max() <= 1.0)
    seen = {"measured": list(job.command), "held": held, "stopped_by": "" if held else "fell"}
    return {"key": job.key, "attempt": asdict(job), **seen, "at_limit": {}, "seconds": 2.0}


class Here:
    """Trials in this process, by `up_to_one`."""

    def __init__(self, file, *_):
        self.file = file

    def begun(self, jobs, fresh):
        return {job.key: up_to_one(job) for job in ([] if fresh else jobs)}

    def carried_out(self, jobs, rows):
        for job in jobs:
            if job.key not in rows:
                rows[job.key] = up_to_one(job)
                with self.file.open("a") as out:
                    print(json.dumps(rows[job.key]), file=out)
                yield len(rows), rows[job.key]


@pytest.fixture
def here(monkeypatch, tmp_path):
    """A file with the trials of a study that are carried out here."""
    monkeypatch.setattr(envelope, "Trials", Here)
    file = tmp_path / "walks.jsonl"
    file.write_text("{}\n")
    return file


def measured(file):
    walks = Walks(file, 6.0, fresh=False)
    found = envelope.measure(["ecd", "srbm"], list(AXES), True, lambda _: None, walks)
    return [deepcopy(one) for one in found], walks


def test_what_is_known_is_told_after_each_axis(here):
    told, walks = measured(here)
    assert [len(d["models"]["ecd"]) + len(d["models"]["srbm"]) for d in told] == list(
        range(1, 2 * len(AXES) + 1)
    )
    assert told[-1]["axes"] == told[-1]["models"]["ecd"]
    assert {row["attempt"]["model"] for row in walks.rows.values()} == {"ecd", "srbm"}
    assert told[-1]["seconds"] == 2.0 * len(walks.rows)
    forward = told[-1]["models"]["srbm"]["forward"]
    assert 0.9 <= forward["size"] <= 1.0
    assert forward["stopped_by"] == "fell"


def test_what_was_walked_is_not_walked_again(here):
    whole, _ = measured(here)
    lines = here.read_text().splitlines()
    here.write_text("\n".join(lines[:20]) + "\n")
    again, _ = measured(here)
    assert again == whole
    assert sorted(here.read_text().splitlines()) == sorted(lines)  # each once


def test_a_walk_that_is_lost_says_why():
    row = lost(Attempt("ecd", "turning", 2.0, 3, 20.0), "too slow")
    assert (row["key"], row["seed"], row["command"]) == ("ecd turning 2 3 20", 3, [0.0, 0.0, 2.0])
    assert (row["held"], row["stopped_by"]) == (False, "too slow")


def test_a_folder_that_cannot_be_written_is_said_before_the_work(tmp_path):
    file = tmp_path / "file"
    file.write_text("")
    with pytest.raises(OutputError):
        command.envelope(out=file, quick=True)


@pytest.mark.slow
def test_an_easy_command_holds_and_a_hopeless_one_does_not():
    said = attempted(Attempt("ecd", "forward", 0.4, 0, 4.0))
    assert said["stopped_by"] == "" if said["held"] else "tracking" in said["stopped_by"]
    said = attempted(Attempt("ecd", "forward", 2.5, 0, 4.0))
    assert not said["held"]
    assert said["stopped_by"]
