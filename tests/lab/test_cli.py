"""The command `linefoot`: what it does with its words, what it prints, how it ends."""

import io
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import threading
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pydrake.geometry import Meshcat
from rich.console import Console

from drake_linefoot import __version__
from drake_linefoot._environment import LOCALE
from drake_linefoot.errors import LinefootError, SolverError
from drake_linefoot.lab import cli
from drake_linefoot.lab.cli import screen
from drake_linefoot.lab.results import tables
from drake_linefoot.lab.results.output import reserved
from drake_linefoot.lab.scenario.edit import with_command, with_duration
from drake_linefoot.lab.scenario.load import load_scenario
from drake_linefoot.lab.simulation import run as simulation
from drake_linefoot.lab.simulation.recording import Run
from drake_linefoot.lab.simulation.run import Progress
from drake_linefoot.lab.visualization import replay
from drake_linefoot.math.compiled import machine_code_folder
from drake_linefoot.resources import diagrams_dir
from drake_linefoot.wbc.control import WholeBodyControl
from tests.helpers.command_line import refuse
from tests.helpers.recorded_runs import make_run

WITHOUT_UTF8 = {"LC_ALL": "POSIX", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
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


@pytest.mark.parametrize("words", [("--help",), ("--version",), ("walk", "--help")])
def test_nobody_reads_what_it_prints(words):
    read, write = os.pipe()
    os.close(read)
    command = [sys.executable, "-m", "drake_linefoot", *words]
    done = subprocess.run(command, check=False, stdout=write, stderr=subprocess.PIPE, timeout=120)
    os.close(write)
    assert (done.returncode, done.stderr) == (141, b"")


def test_version(capsys):
    assert cli.main(["--version"]) == 0
    assert capsys.readouterr().out.startswith("drake_linefoot 0.")


def test_help_does_not_import_drake():
    code = "import sys; from drake_linefoot.lab.cli import main; main(['--help']);"
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
        (
            ("walk", "--model", "lip"),
            "'--model': 'lip' must be one of ['ecd', 'contact_consistent', ",
        ),
        (("walk", "--speed", "1"), "No such option: --speed"),
        (("walk", "--vx"), "Option '--vx' requires an argument"),
        (("walk", "a", "b"), "unexpected extra argument"),
        (("run",), "No such command 'run'"),
        (("replay",), "Missing argument 'DIR'"),
        (("replay", ".", "--begin", "-1"), "'--begin': '-1' must be a number from 0 on, in s"),
        (("walk", "nowhere.yaml"), "scenario = 'nowhere.yaml': no such file; must be one of"),
        (("draw", "nowhere"), "draw = 'nowhere': no such scenario or system; must be one of"),
        (("draw", "nowhere.yaml"), "scenario = 'nowhere.yaml': no such file; must be one of"),
        (("draw", "ecd_mpc", "--of", "nowhere"), "scenario = 'nowhere': no such file"),
        (("replay", "nowhere"), "nowhere/log.arrow"),
    ],
)
def test_bad_words_are_refused_with_one_line(capsys, words, said):
    assert said in refuse(capsys, *words)


@pytest.mark.parametrize(
    "words",
    [
        ("x" * 5000,),
        ("walk", "x" * 5000),
        ("walk", "--vx", "x" * 5000),
        ("walk", "--out", "y" * 300),
        ("walk", "--out", "loop"),
        ("walk", "--robot", "y" * 300),
        ("walk", "--log", "1e-308"),
        ("log", "x" * 5000),
        ("log", "loop"),
        ("replay", "loop", "--begin", "1e-308"),
        ("draw", "y" * 300),
        ("new-robot", "y" * 300),
        ("new-robot", "\x1b]0;pwned\a"),
        ("sweep", "y" * 300),
    ],
)
def test_words_and_paths_that_are_none_are_one_short_line(capsys, tmp_path, monkeypatch, words):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "loop").symlink_to("loop")
    said = refuse(capsys, *words)
    assert len(said) < 1200
    assert said.rstrip("\n").isprintable()
    assert "unexpected" not in said


def test_notes_of_a_model_move_no_cursor(capsys):
    screen.say("torso\x1b[2J: mended\n" + "x" * 5000)
    assert capsys.readouterr().out.startswith(r"torso\x1b[2J: mended xxx")


def test_a_locale_without_letters_is_said_with_what_to_do():
    done = run_process(
        "show", env={**os.environ, **WITHOUT_UTF8, "PYTHONPATH": str(diagrams_dir().parent)}
    )
    assert done.returncode == 2
    assert done.stderr.endswith("set LC_ALL=C.UTF-8, or PYTHONUTF8=1\n")
    assert "\n" not in done.stderr[:-1]


def test_so_it_is_in_python():
    code = "try: from drake_linefoot import walk\nexcept ImportError as error: print(error)"
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, **WITHOUT_UTF8, "PYTHONPATH": str(diagrams_dir().parent)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout == f"the locale of the environment {LOCALE}\n"


def test_a_home_that_cannot_be_written_is_nothing_to_talk_about(tmp_path):
    (tmp_path / "home").touch()
    home = {"HOME": str(tmp_path / "home"), "PYTHONPATH": str(diagrams_dir().parent)}
    kept = {"NUMBA_CACHE_DIR": str(machine_code_folder().parent)}
    words = ("walk", "stand", "--duration", "0.05", "--no-replay")
    done = run_process(*words, cwd=tmp_path, env={**os.environ, **home, **kept})
    assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "out" / "walk" / "plots" / "pressure.png").exists()


def test_a_full_disk_behind_what_is_printed_is_nobody_who_reads_it():
    with Path("/dev/full").open("w") as full:
        command = [sys.executable, "-m", "drake_linefoot", "--help"]
        done = subprocess.run(command, check=False, stdout=full, timeout=120)
    assert done.returncode == 141


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


def test_a_folder_that_another_run_writes_to_is_refused(capsys, tmp_path, simulated):
    with reserved(tmp_path / "out"):
        said = refuse(capsys, *SHORT, "--out", str(tmp_path / "out"))
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
    assert cli.main([*SHORT[:-1], "--out", str(tmp_path / "out")]) == 0
    assert (tmp_path / "out/replay.html").exists()


def test_a_missing_replay_is_said_in_a_line(capsys, tmp_path, monkeypatch):
    monkeypatch.setattr(replay, "PROGRAM", (sys.executable, "-c", "import os; os.abort()"))
    assert cli.main([*SHORT[:-1], "--out", str(tmp_path / "out")]) == 0
    out, err = capsys.readouterr()
    expected = f"{tmp_path}/out/replay.html: not drawn: its process was ended by SIGABRT"
    assert err == f"linefoot: the replay is missing: {expected}\n"
    assert out.rstrip().endswith(str(tmp_path / "out"))
    assert Run.load(tmp_path / "out").time[-1] > 0.09


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


@pytest.mark.parametrize(
    ("number", "said"), [(signal.SIGINT, "interrupted"), (signal.SIGTERM, "terminated")]
)
def test_interrupt_is_status_130_or_143_and_what_was_simulated_is_written(
    capsys, tmp_path, monkeypatch, number, said
):
    simulate = simulation.simulate

    def interrupted(*args, **options):
        timer = threading.Timer(0.3, os.kill, (os.getpid(), number))
        timer.start()
        try:
            return simulate(*args, **options)
        finally:
            timer.join()

    monkeypatch.setattr(simulation, "simulate", interrupted)
    assert cli.main(["walk", "--out", str(tmp_path / "out")]) == 128 + number
    out, err = capsys.readouterr()
    assert err == f"linefoot: {said}\n"
    assert out.rstrip().endswith(str(tmp_path / "out"))  # there is no replay
    run = Run.load(tmp_path / "out")
    assert 0.0 <= run.time[-1] < run.scenario.duration
    assert not run.fell
    assert json.loads((tmp_path / "out/metrics.json").read_text())["fell"] is False
    assert [path.name for path in tmp_path.iterdir()] == ["out"]
    assert signal.getsignal(number) in {signal.default_int_handler, signal.SIG_DFL}


def test_a_second_interrupt_ends_at_once_and_writes_nothing(capsys, tmp_path, monkeypatch):
    def interrupted_twice(*_, **__):
        os.kill(os.getpid(), signal.SIGINT)
        os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr(simulation, "simulate", interrupted_twice)
    assert cli.main(["walk", "--no-replay", "--out", str(tmp_path / "out")]) == 130
    assert capsys.readouterr().err == "linefoot: interrupted\n"
    assert list(tmp_path.iterdir()) == []


def test_an_error_that_nobody_foresaw_is_status_3_and_what_was_simulated_is_written(
    capsys, tmp_path, monkeypatch
):
    compute, ticks = WholeBodyControl.compute, []

    def fail(*args):
        ticks.append(1)
        if len(ticks) == 60:
            raise IndexError("list index out of range")
        return compute(*args)

    monkeypatch.setattr(WholeBodyControl, "compute", fail)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    assert cli.main([*SHORT, "--out", str(tmp_path / "out")]) == 3
    out, err = capsys.readouterr()
    assert out.rstrip() == str(tmp_path / "out")
    assert err.startswith("linefoot: unexpected error, IndexError: list index out of range (its ")
    assert err.count("\n") == 1
    kept = Path(re.search(r"traceback is in (\S+)\)", err)[1])
    assert "whole_body_controller.py" in kept.read_text(encoding="utf-8")
    assert 0.05 < Run.load(tmp_path / "out").time[-1] < 0.06


# --------------------------------------------------------------------------- the last resort


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (ZeroDivisionError("by nothing"), "unexpected error, ZeroDivisionError: by nothing ("),
        (SystemExit("Drake"), "unexpected error, SystemExit: Drake ("),
        (MemoryError(), "unexpected error, MemoryError ("),
        (ValueError("x" * 10**6 + "\n"), f"ValueError: {'x' * 188}... ("),
    ],
)
def test_a_crash_is_no_fall(capsys, tmp_path, monkeypatch, error, said):
    def crash(*_, **__):
        raise error

    monkeypatch.setattr(simulation, "simulate", crash)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    assert cli.main([*SHORT, "--out", str(tmp_path / "out")]) == 3
    err = capsys.readouterr().err
    assert said in err
    assert err.count("\n") == 1
    (kept,) = tmp_path.glob("*.txt")
    assert f"(its traceback is in {kept})" in err
    assert "in crash" in kept.read_text(encoding="utf-8")


def test_an_interrupt_inside_compiled_code_is_an_interrupt(capsys, tmp_path, monkeypatch):
    def interrupted(*_, **__):
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt as interrupt:
            raise SystemError("returned a result with an exception set") from interrupt

    monkeypatch.setattr(simulation, "simulate", interrupted)
    assert cli.main([*SHORT, "--out", str(tmp_path / "out")]) == 130
    assert capsys.readouterr().err == "linefoot: interrupted\n"


def test_progress_names_time_rate_and_both_velocities():
    progress = simulation.Progress(1.5, 14.0, 0.5, (0.4, 0.0, 0.0), (0.38, -0.01, 0.0), ())
    first, second = tables.progress_text(progress).splitlines()
    assert first == " 1.50 of 14.00 s, 0.50 x real time"
    assert second == "commanded  0.40  0.00  0.00, measured  0.38 -0.01  0.00"
    slowed = tables.progress_text(progress._replace(warnings=("command limited: slope", "a")))
    assert slowed.splitlines()[0] == f"{first}, command limited: slope, a"


def test_a_simulator_is_chosen(simulated, tmp_path, capsys):
    pytest.importorskip("mujoco", reason="MuJoCo is not installed: the extra mujoco")
    out = ("--out", str(tmp_path / "out"))
    assert cli.main([*SHORT, *out, "--simulator", "mujoco"]) == 3
    assert simulated[0].scenario.plant.simulator == "mujoco"
    assert type(simulated[0].plant.system).__name__ == "MujocoStep"
    capsys.readouterr()
    other = refuse(capsys, *SHORT, *out, "--simulator", "bullet")
    assert other.startswith("linefoot: command line: plant.simulator = 'bullet': must be one of")
    missing = refuse(capsys, *SHORT, *out, "--mjcf", str(tmp_path / "none.xml"))
    assert "plant.mujoco.mjcf" in missing and "MuJoCo refuses it" in missing


def test_without_a_terminal_a_slow_walk_says_now_and_then_how_far_it_is(monkeypatch):
    now, console = [0.0], Console(file=io.StringIO(), width=110)
    monkeypatch.setattr(tables.clock, "monotonic", lambda: now[0])
    with tables.progress_bar(console) as progress:
        for now[0] in (10.0, 61.0, 100.0, 122.0):
            progress(Progress(0.01 * now[0], 9.0, 0.01, np.zeros(3), np.zeros(3), ()))
    assert console.file.getvalue().splitlines() == [
        " 0.61 of 9.00 s, 0.01 x real time",
        " 1.22 of 9.00 s, 0.01 x real time",
    ]
