"""The command `linefoot`: its words, what it refuses, where it runs."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from drake_linefoot._environment import LOCALE
from drake_linefoot.lab import cli
from drake_linefoot.lab.cli import screen
from drake_linefoot.math.compiled import machine_code_folder
from drake_linefoot.resources import diagrams_dir
from tests.helpers.command_line import refuse

WITHOUT_UTF8 = {"LC_ALL": "POSIX", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}


def run_process(*words, **options):
    command = [sys.executable, "-m", "drake_linefoot", *words]
    return subprocess.run(
        command, check=False, capture_output=True, text=True, timeout=120, **options
    )


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
