"""Words of `linefoot` that change a scenario, a page or a robot, and what is refused of them."""

import os

import pytest

from drake_linefoot.errors import LinefootError
from drake_linefoot.lab import cli
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.scenario.load import load_scenario, validate
from drake_linefoot.lab.simulation import run as simulation
from drake_linefoot.lab.simulation.recording import LOG, Run
from drake_linefoot.lab.visualization import live
from drake_linefoot.robot.humanoid import load_humanoid
from tests.helpers.command_line import refuse
from tests.helpers.recorded_runs import leave_unfinished, make_run
from tests.helpers.small_biped import copied


@pytest.fixture
def simulated(monkeypatch):
    """Scenarios that would have been simulated; the command breaks off instead."""
    scenarios = []

    def simulate(loop, *_, **__):
        scenarios.append(loop.scenario)
        raise LinefootError("not simulated")

    monkeypatch.setattr(simulation, "simulate", simulate)
    return scenarios


@pytest.fixture
def robot(tmp_path, small_biped_files):
    """A folder with the description of a robot, as `linefoot new-robot` leaves it."""
    file = copied(small_biped_files["small biped"], tmp_path / "small")
    text = f"name: small walks\nrobot: {file.name}\n"
    file.with_name("walk.yaml").write_text(text, encoding="utf-8")
    return file.parent


def test_fields_and_pushes_are_those_of_the_run(simulated, tmp_path):
    words = ["--set", "gait.swing_height=0.08", "--set", "mpc.model=srbm", "--set", "seed=7"]
    pushes = ["--push", "1.0,5", "--push", "2.5,8,-1.57"]
    cli.main(["walk", *words, *pushes, "--out", str(tmp_path / "out")])
    (run,) = simulated
    assert (run.gait.swing_height, run.mpc.model, run.seed) == (0.08, "srbm", 7)
    said = [(push.time, push.impulse, push.direction, push.duration) for push in run.pushes]
    assert said == [(1.0, 5.0, 0.0, 0.1), (2.5, 8.0, -1.57, 0.1)]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--set", "seed"], "'seed' must be FIELD=VALUE"),
        (["--set", "=3"], "'=3' must be FIELD=VALUE"),
        (["--set", "gait.foo=1"], "gait.foo = 1: no such field"),
        (["--set", "gait.swing_height=[0"], "--set gait.swing_height"),
        (["--set", "mpc.model=none"], "mpc.model = 'none': must be one of"),
        (["--push", "1"], "'1' must be a time [s], an impulse [N s]"),
        (["--push", "1,2,3,4"], "'1,2,3,4' must be a time"),
        (["--push", "1,strong"], "'1,strong' must be a time"),
        (["--push", "1,-5"], "pushes[0].impulse = -5.0: must be greater than or equal to 0"),
    ],
)
def test_what_is_wrong_with_them_is_a_line(capsys, words, said):
    assert said in refuse(capsys, "walk", *words)


def test_every_page_can_be_given_its_port(capsys, monkeypatch, tmp_path):
    asked = []

    def page(host, port):
        asked.append((host, port))
        raise LinefootError("no page")

    monkeypatch.setattr(live, "live_page", page)
    make_run([0.0, 0.1]).save(tmp_path / LOG)
    out = ["--out", str(tmp_path / "out")]
    for words in (["replay", str(tmp_path)], ["show"], ["walk", "--live", *out], ["drive"]):
        assert cli.main([*words, "--port", "7123"]) == 3
        assert capsys.readouterr().err == "linefoot: no page\n"
    assert asked == [("localhost", 7123)] * 4


def test_a_page_says_what_to_press(capsys):
    assert cli.main(["show", "--loop-once"]) == 0
    where, press = capsys.readouterr().out.splitlines()
    assert where.startswith("Live at http://") and press.startswith("Drag its sliders")


def test_a_robot_is_its_folder_wherever_one_is_taken(robot, capsys, simulated, monkeypatch):
    monkeypatch.chdir(robot.parent)
    name = load_humanoid("small").description.name
    assert load_humanoid(robot / f"{small_file(robot)}").description.name == name
    assert validate(Scenario(robot="small")).robot == "small"
    assert cli.main(["show", "small", "--loop-once"]) == 0
    cli.main(["walk", "--robot", "small"])
    assert simulated[0].name == "small walks"
    os.mkdir("empty")
    for words in (["show", "empty"], ["walk", "--robot", "empty"]):
        capsys.readouterr()
        assert "must be a folder with one description" in refuse(capsys, *words)
    with pytest.raises(ValueError, match="not usable: empty"):
        validate(Scenario(robot="empty"))


def small_file(folder):
    """Return the name of the description in a folder."""
    (file,) = {path.name for path in folder.glob("*.yaml")} - {"walk.yaml"}
    return file


def test_a_scenario_finds_its_robot_from_another_folder(robot, tmp_path, monkeypatch):
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    scenario = load_scenario(robot / "walk.yaml")
    assert scenario.robot == str(robot / small_file(robot))
    assert load_humanoid(scenario.robot).description.name
    monkeypatch.chdir(tmp_path)
    assert load_scenario("small/walk.yaml").robot == f"small/{small_file(robot)}"


def test_where_nothing_is_beside_it_the_current_folder_counts(robot, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    name = small_file(robot)
    text = f"robot: small/{name}\nscene: flat_ground\n"
    (tmp_path / "small" / "other.yaml").write_text(text, encoding="utf-8")
    scenario = load_scenario(tmp_path / "small" / "other.yaml")
    assert (scenario.robot, scenario.scene) == (f"small/{name}", "flat_ground")


# --------------------------------------------------------------------------- runs that were killed


def test_a_killed_run_is_not_upright(tmp_path, capsys):
    leave_unfinished(tmp_path / "out.part", make_run([0.0, 0.1, 0.2]), 2)
    run = Run.load(tmp_path / "out")
    assert not run.ended and not run.fell
    assert "it was killed, broke off or goes on" in repr(run) and "upright" not in repr(run)
    assert cli.main(["log", str(tmp_path / "out")]) == 0
    assert "the run has not ended" in capsys.readouterr().out
    run.save(tmp_path / LOG)  # what an error has left is written so
    assert not Run.load(tmp_path / LOG).ended


def test_without_a_sample_there_is_nothing_to_show(tmp_path, capsys):
    leave_unfinished(tmp_path / "out.part", make_run([0.0, 0.1, 0.2]), 0)
    assert "has no sample" in refuse(capsys, "replay", str(tmp_path / "out"))
    (tmp_path / "out.part" / LOG).write_bytes(b"")
    for command in ("log", "replay"):
        said = refuse(capsys, command, str(tmp_path / "out"))
        assert said.endswith("is empty: the run ended before anything was recorded\n")


def test_what_goes_to_the_disk_says_how_it_ended(tmp_path):
    """The replay is drawn from it, which says that the robot fell."""
    from drake_linefoot.lab.simulation.run import finished_run, keep_on_disk
    from drake_linefoot.lab.wiring.closed_loop import build_closed_loop

    loop = build_closed_loop(Scenario())
    keep_on_disk(loop, tmp_path)
    loop.make_simulator().AdvanceTo(0.01)
    assert not Run.load(tmp_path / LOG).ended
    loop.recorder.end(finished_run(loop, "torso low", 0.01, 1.0).facts()[1])
    run = Run.load(tmp_path / LOG)
    assert run.ended and run.fell and run.fall_reason == "torso low" and len(run.time) == 11
