"""`linefoot walk`: what its options change, what it writes and says."""

import json
import sys

import pytest
from pydrake.geometry import Meshcat

from drake_linefoot import __version__
from drake_linefoot.lab import cli
from drake_linefoot.lab.results.output import reserved
from drake_linefoot.lab.scenario.load import load_scenario
from drake_linefoot.lab.simulation.recording import Run
from drake_linefoot.lab.visualization import replay
from tests.helpers.command_line import SHORT_WALK, refuse
from tests.helpers.recorded_runs import make_run


def test_output_folder_is_checked_before_anything_is_simulated(capsys, tmp_path, simulated):
    (tmp_path / "file").touch()
    said = refuse(capsys, "walk", "--out", str(tmp_path / "file" / "out"))
    assert "file/out: cannot be written" in said
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "precious.txt").touch()
    assert "precious.txt" in refuse(capsys, "walk", "--out", str(tmp_path / "other"))
    assert simulated == []


def test_a_folder_that_another_run_writes_to_is_refused(capsys, tmp_path, simulated):
    with reserved(tmp_path / "out"):
        said = refuse(capsys, *SHORT_WALK, "--out", str(tmp_path / "out"))
    assert "another run writes there" in said
    assert simulated == []


def test_options_change_the_scenario(capsys, tmp_path, simulated):
    words = ["walk", "--vx", "-0.3", "--turn", "0.2", "--duration", "2.5", "--seed", "5"]
    words += ["--model", "srbm", "--no-replay", "--out", str(tmp_path / "out")]
    assert cli.main(words) == 3
    assert capsys.readouterr().err == "linefoot: not simulated\n"
    (loop,) = simulated
    stand, walk = loop.scenario.segments
    assert (stand.duration, stand.walk) == (1.0, False)
    assert (walk.duration, walk.walk) == (1.5, True)
    assert (walk.velocity, walk.turn_rate) == ([-0.3, 0.0], 0.2)
    assert (loop.scenario.seed, loop.scenario.mpc.model) == (5, "srbm")
    assert loop.meshcat is None
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--vx", "9", "--turn", "-3"], "walk: forward 9 m/s is beyond the limit of 2.6 m/s"),
        (["--vx", "9", "--turn", "-3"], "walk: turn -3 rad/s is beyond the limit of 2 rad/s"),
        (["--vx", "0.3", "--duration", "0.5"], "too short to walk: the first 0.5 s are spent"),
        (["--vx", "0.3", "--duration", "1.2"], "too short to walk: 0.2 s of walking"),
        (["--duration", "0.2"], "too short to walk: the first 0.2 s are spent"),
    ],
)
def test_what_will_not_be_walked_is_said_before_it_is_simulated(
    capsys, tmp_path, simulated, words, said
):
    assert cli.main(["walk", *words, "--no-replay", "--out", str(tmp_path / "out")]) == 3
    assert said in capsys.readouterr().out


@pytest.mark.parametrize("words", [["stand", "--duration", "0.5"], ["--vx", "2.6"], []])
def test_what_is_walked_needs_no_remark(capsys, tmp_path, simulated, words):
    cli.main(["walk", *words, "--no-replay", "--out", str(tmp_path / "out")])
    assert capsys.readouterr().out == ""


def test_without_options_the_scenario_is_run_as_it_is(tmp_path, simulated):
    cli.main(["walk", "--no-replay", "--out", str(tmp_path / "out")])
    assert simulated[0].scenario == load_scenario("walk")


def test_run_writes_its_results_and_says_where(capsys, tmp_path):
    out = tmp_path / "deep" / "out"
    assert cli.main([*SHORT_WALK, "--out", str(out)]) == 0
    printed, err = capsys.readouterr()
    assert err == ""
    assert printed.rstrip().endswith(str(out))
    assert "Velocity: forward, left [m/s], turn rate [rad/s]" in printed
    assert "0.100 s, " in printed
    metrics = json.loads((out / "metrics.json").read_text(encoding="utf-8"))
    assert metrics["duration_s"] == pytest.approx(0.1)
    assert not (out / "replay.html").exists()


def test_replay_is_written_and_shown_again(capsys, tmp_path):
    assert cli.main([*SHORT_WALK[:-1], "--out", str(tmp_path / "out")]) == 0
    assert capsys.readouterr().out.rstrip().endswith("replay.html")
    page = (tmp_path / "out/replay.html").read_text(encoding="utf-8")
    assert f"<title>stand, drake_linefoot {__version__}</title>" in page
    assert cli.main(["replay", str(tmp_path / "out"), "--loop-once"]) == 0
    out, err = capsys.readouterr()
    assert out.startswith("Replay at http://localhost:")
    assert out.endswith("/view/\nSpace plays and pauses it; Ctrl-C here ends it\n")
    assert err == ""


def test_ctrl_c_is_the_end_of_a_replay_and_of_a_show(capsys, tmp_path, monkeypatch):
    def interrupt(*_):
        raise SystemError("in compiled code") from KeyboardInterrupt()

    make_run([0.0, 0.1]).save(tmp_path / "log.arrow")
    monkeypatch.setattr("drake_linefoot.lab.visualization.replay.draw", interrupt)
    monkeypatch.setattr("drake_linefoot.lab.visualization.show.make_visualizer", interrupt)
    for words in (["replay", str(tmp_path)], ["show"]):
        assert cli.main(words) == 0
        assert capsys.readouterr().err == ""


def test_a_walk_opens_no_meshcat_before_its_data_is_written(capsys, tmp_path, monkeypatch):
    """A replay is drawn by another process, from what is on the disk."""

    def abort(self, *_, **__):
        raise AssertionError("Meshcat in the process of the simulation")

    monkeypatch.setattr(Meshcat, "__init__", abort)
    assert cli.main([*SHORT_WALK[:-1], "--out", str(tmp_path / "out")]) == 0
    assert (tmp_path / "out/replay.html").exists()


def test_a_missing_replay_is_said_in_a_line(capsys, tmp_path, monkeypatch):
    monkeypatch.setattr(replay, "PROGRAM", (sys.executable, "-c", "import os; os.abort()"))
    assert cli.main([*SHORT_WALK[:-1], "--out", str(tmp_path / "out")]) == 0
    out, err = capsys.readouterr()
    expected = f"{tmp_path}/out/replay.html: not drawn: its process was ended by SIGABRT"
    assert err == f"linefoot: the replay is missing: {expected}\n"
    assert out.rstrip().endswith(str(tmp_path / "out"))
    assert Run.load(tmp_path / "out").time[-1] > 0.09


def test_live_says_where(capsys, tmp_path, simulated):
    cli.main(["walk", "--live", "--no-replay", "--out", str(tmp_path / "out")])
    assert capsys.readouterr().out.startswith("Live at http://")
    assert simulated[0].meshcat is not None


def test_a_simulator_is_chosen(simulated, tmp_path, capsys):
    pytest.importorskip("mujoco", reason="MuJoCo is not installed: the extra mujoco")
    out = ("--out", str(tmp_path / "out"))
    assert cli.main([*SHORT_WALK, *out, "--simulator", "mujoco"]) == 3
    assert simulated[0].scenario.plant.simulator == "mujoco"
    assert type(simulated[0].plant.system).__name__ == "MujocoStep"
    capsys.readouterr()
    other = refuse(capsys, *SHORT_WALK, *out, "--simulator", "bullet")
    assert other.startswith("linefoot: command line: plant.simulator = 'bullet': must be one of")
    missing = refuse(capsys, *SHORT_WALK, *out, "--mjcf", str(tmp_path / "none.xml"))
    assert "plant.mujoco.mjcf" in missing and "MuJoCo refuses it" in missing
