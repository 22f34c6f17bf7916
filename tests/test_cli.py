"""The command `linefoot`: what it does with its words, what it prints, how it ends."""

import json
import os
import signal
import subprocess
import sys
import threading
from dataclasses import replace

import pytest

from drake_linefoot import __version__, cli
from drake_linefoot.errors import LinefootError, SolverError
from drake_linefoot.resources import diagrams_dir
from drake_linefoot.results import tables
from drake_linefoot.scenario.edit import with_command, with_duration
from drake_linefoot.scenario.load import load_scenario
from drake_linefoot.simulation import run as simulation
from tests.helpers.command_line import refuse

SHORT = ("walk", "stand", "--duration", "0.1", "--no-replay")


@pytest.fixture
def simulated(monkeypatch):
    """Loops that would have been simulated; the command breaks off instead."""
    loops = []

    def simulate(loop, *_, **__):
        loops.append(loop)
        raise LinefootError("not simulated")

    monkeypatch.setattr(simulation, "simulate", simulate)
    return loops


def run_process(*words, **options):
    command = [sys.executable, "-m", "drake_linefoot", *words]
    return subprocess.run(
        command, check=False, capture_output=True, text=True, timeout=120, **options
    )


# ------------------------------------------------------------------------------ the words


@pytest.mark.parametrize("words", [("--help",), ("walk", "--help"), ()])
def test_help(capsys, words):
    assert cli.main(words) == 0
    assert "Usage: linefoot" in capsys.readouterr().out


def test_version(capsys):
    assert cli.main(["--version"]) == 0
    assert capsys.readouterr().out.startswith("drake_linefoot 0.")


def test_help_does_not_import_drake():
    code = "import sys; from drake_linefoot.cli import main; main(['--help']);"
    code += "sys.exit('pydrake' in sys.modules or 'numpy' in sys.modules)"
    subprocess.run([sys.executable, "-c", code], capture_output=True, check=True, timeout=60)


def test_module_is_the_command():
    done = run_process("--version")
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("drake_linefoot ")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("walk", "--vx", "abc"), "'--vx': 'abc' must be a finite number"),
        (("walk", "--vx", "nan"), "'--vx': 'nan' must be a finite number"),
        (("walk", "--turn", "-inf"), "'--turn': '-inf' must be a finite number"),
        (("walk", "--duration", "0"), "'--duration': '0' must be a number above 0, in s"),
        (("walk", "--seed", "1.5"), "'--seed': '1.5' must be a whole number from 0"),
        (("walk", "--seed", "-1"), "'--seed': '-1' must be a whole number from 0"),
        (("walk", "--seed", "9" * 30), "must be a whole number from 0"),
        (("walk", "--model", "lip"), "'--model': 'lip' must be one of ['ecd', 'srbm']"),
        (("walk", "--speed", "1"), "No such option: --speed"),
        (("walk", "--vx"), "Option '--vx' requires an argument"),
        (("walk", "a", "b"), "unexpected extra argument"),
        (("run",), "No such command 'run'"),
        (("replay",), "Missing argument 'DIR'"),
        (("replay", ".", "--rate", "-1"), "'--rate': '-1' must not be negative"),
        (("walk", "nowhere.yaml"), "scenario = 'nowhere.yaml': no such file; must be one of"),
        (("draw", "nowhere"), "draw = 'nowhere': no such scenario or system; must be one of"),
        (("draw", "nowhere.yaml"), "scenario = 'nowhere.yaml': no such file; must be one of"),
        (("draw", "ecd_mpc", "--of", "nowhere"), "scenario = 'nowhere': no such file"),
        (("replay", "nowhere"), "nowhere/log.npz"),
    ],
)
def test_bad_words_are_refused_with_one_line(capsys, words, said):
    assert said in refuse(capsys, *words)


def test_bad_input_leaves_nothing_behind_and_stays_one_line_in_a_process(tmp_path):
    (tmp_path / "a.yaml").write_text("gait: {step_width: 9.0}", encoding="utf-8")
    environment = {**os.environ, "PYTHONPATH": str(diagrams_dir().parent)}
    done = run_process("walk", "a.yaml", cwd=tmp_path, env=environment)
    assert (done.returncode, done.stdout) == (2, "")
    allowed = "must lie in [0.1, 0.45], the limits of MIT Humanoid"
    assert done.stderr == f"linefoot: a.yaml: gait.step_width = 9.0: {allowed}\n"
    assert [path.name for path in tmp_path.iterdir()] == ["a.yaml"]


def test_output_folder_is_checked_before_anything_is_simulated(capsys, tmp_path, simulated):
    (tmp_path / "file").touch()
    said = refuse(capsys, "walk", "--out", str(tmp_path / "file" / "out"))
    assert "file/out: cannot be written" in said
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "precious.txt").touch()
    assert "precious.txt" in refuse(capsys, "walk", "--out", str(tmp_path / "other"))
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


def test_without_options_the_scenario_is_run_as_it_is(tmp_path, simulated):
    cli.main(["walk", "--no-replay", "--out", str(tmp_path / "out")])
    assert simulated[0].scenario == load_scenario("walk")


# ------------------------------------------------------------------- changes to a scenario


def test_shorter_duration_cuts():
    scenario = load_scenario("walk")
    cut = with_duration(scenario, 1.5)
    assert [s.duration for s in cut.segments] == [1.0, 0.5]
    assert scenario == load_scenario("walk")
    assert [s.duration for s in with_duration(scenario, 1.0).segments] == [1.0]


def test_longer_duration_holds_the_last_segment():
    scenario = load_scenario("walk")
    longer = with_duration(scenario, scenario.duration + 2.0)
    assert longer.segments[:-1] == scenario.segments[:-1]
    assert longer.segments[-1].duration == pytest.approx(scenario.segments[-1].duration + 2.0)


def test_same_duration_changes_nothing():
    scenario = load_scenario("walk")
    assert with_duration(scenario, scenario.duration) == scenario


def test_command_keeps_the_length():
    scenario = load_scenario("walk")
    changed = with_command(scenario, 0.4, 0.0, 0.0)
    assert changed.duration == pytest.approx(scenario.duration)
    assert [s.walk for s in changed.segments] == [False, True]


# -------------------------------------------------------------------------------- the runs


def test_run_writes_its_results_and_says_where(capsys, tmp_path):
    out = tmp_path / "deep" / "out"
    assert cli.main([*SHORT, "--out", str(out)]) == 0
    printed, err = capsys.readouterr()
    assert err == ""
    assert printed.rstrip().endswith(str(out))
    assert "Velocity: forward, left [m/s], turn rate [rad/s]" in printed
    assert "0.100 s, " in printed
    metrics = json.loads((out / "metrics.json").read_text(encoding="utf-8"))
    assert metrics["duration_s"] == pytest.approx(0.1)
    assert not (out / "replay.html").exists()


def test_replay_is_written_and_shown_again(capsys, tmp_path):
    assert cli.main([*SHORT[:-1], "--out", str(tmp_path / "out")]) == 0
    assert capsys.readouterr().out.rstrip().endswith("replay.html")
    page = (tmp_path / "out/replay.html").read_text(encoding="utf-8")
    assert f"<title>stand, drake_linefoot {__version__}</title>" in page
    assert cli.main(["replay", str(tmp_path / "out"), "--loop-once", "--rate", "0"]) == 0
    out, err = capsys.readouterr()
    assert out.startswith("Live at http://")
    assert err == ""


def test_live_says_where(capsys, tmp_path, simulated):
    cli.main(["walk", "--live", "--no-replay", "--out", str(tmp_path / "out")])
    assert capsys.readouterr().out.startswith("Live at http://")
    assert simulated[0].meshcat is not None


def test_fall_is_status_1_and_everything_is_written(capsys, tmp_path, monkeypatch):
    simulate = simulation.simulate

    def fall(*args, **options):
        run = simulate(*args, **options)
        return replace(run, fell=True, fall_time=0.1, fall_reason="torso [low]")

    monkeypatch.setattr(simulation, "simulate", fall)
    assert cli.main([*SHORT, "--out", str(tmp_path / "out")]) == 1
    assert "The robot FELL at 0.100 s: torso [low]" in capsys.readouterr().out
    assert json.loads((tmp_path / "out/metrics.json").read_text())["fell"] is True


def test_solver_that_gives_up_is_status_3(capsys, tmp_path, monkeypatch):
    def give_up(*_, **__):
        raise SolverError("contact", "infeasible")

    monkeypatch.setattr(simulation, "simulate", give_up)
    assert cli.main([*SHORT, "--out", str(tmp_path / "out")]) == 3
    assert capsys.readouterr().err == "linefoot: contact program not solved: infeasible\n"


def test_interrupt_is_status_130_and_writes_nothing(capsys, tmp_path, monkeypatch):
    simulate = simulation.simulate

    def interrupted(*args, **options):
        timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
        timer.start()
        try:
            return simulate(*args, **options)
        finally:
            timer.join()

    monkeypatch.setattr(simulation, "simulate", interrupted)
    assert cli.main(["walk", "--no-replay", "--out", str(tmp_path / "out")]) == 130
    assert capsys.readouterr().err == "linefoot: interrupted\n"
    assert list(tmp_path.iterdir()) == []


def test_progress_names_time_rate_and_both_velocities():
    progress = simulation.Progress(1.5, 14.0, 0.5, (0.4, 0.0, 0.0), (0.38, -0.01, 0.0))
    first, second = tables.progress_text(progress).splitlines()
    assert first == " 1.50 of 14.00 s, 0.50 x real time"
    assert second == "commanded  0.40  0.00  0.00, measured  0.38 -0.01  0.00"
