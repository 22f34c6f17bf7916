"""The commands that look into things: `linefoot log`, `draw` and `show`."""

import re
import subprocess
import sys

import numpy as np
import pytest

from drake_linefoot.lab import cli
from drake_linefoot.lab.simulation.recording import CHANNELS
from drake_linefoot.resources import diagrams_dir
from drake_linefoot.signals import CentroidalPlan, Reference, RobotDynamics
from tests.helpers.command_line import refuse
from tests.helpers.recorded_runs import leave_unfinished, make_run, mcap_log

TIME = np.arange(101) * 1e-3


@pytest.mark.parametrize(
    "words", [["--help"], ["log", "--help"], ["draw", "--help"], ["show", "--help"]]
)
def test_help_imports_nothing_heavy(words):
    heavy = ("pydrake", "numpy", "plotly", "mcap", "matplotlib")
    code = f"import sys; from drake_linefoot.lab.cli import main; main({words});"
    code += f"sys.exit(any(name in sys.modules for name in {heavy}))"
    subprocess.run([sys.executable, "-c", code], capture_output=True, check=True, timeout=60)


# ------------------------------------------------------------------------------------- logs


@pytest.fixture
def folder(tmp_path):
    """A run without pictures."""
    run, folder = make_run(TIME), tmp_path / "run"
    folder.mkdir()
    run.save(folder / "log.arrow")
    (folder / "log.mcap").write_bytes(mcap_log(run, 500.0))
    return folder


def rows_of(printed):
    """The cells of the printed table by the name in its first column."""
    rows = [line.strip("│ ").split("│") for line in printed.splitlines() if line[:1] == "│"]
    return {row[0].strip(): [cell.strip() for cell in row[1:]] for row in rows}


def test_log_prints_every_channel(capsys, folder):
    assert cli.main(["log", str(folder)]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert "log.arrow 0.2" in out and "log.mcap 0.1" in out and "2 samples per message" in out
    rows = rows_of(out)
    assert rows.keys() == {*CHANNELS, "rpy"}
    unit, shape, samples, rate, kilobytes, messages = rows["mpc_wrench"]
    assert (unit, shape, samples, rate, messages) == ("N, N m", "2 x 5", "101", "1000", "51")
    assert float(kilobytes) > 0.0
    assert rows["rpy"] == ["rad", "3", "-", "1000", "-", "51"]
    assert rows["time"][-1] == "-"


def test_log_of_a_run_that_has_not_ended(capsys, folder):
    leave_unfinished(folder.parent / "other.part", make_run(TIME), 51)
    for path in ("other", "other.part"):
        assert cli.main(["log", str(folder.parent / path)]) == 0
        out, err = capsys.readouterr()
        assert "log.arrow: a run that has not ended, up to 0.050 s" in " ".join(out.split())
        rows = rows_of(out)
        assert rows["com"] == ["m", "3", "51", "1000", "1.2", "-"]
        assert err == ""
    (folder.parent / "run.part").mkdir()
    assert cli.main(["log", str(folder)]) == 0
    assert "run.part has a later run, which has not ended" in capsys.readouterr().out


def test_log_without_mcap(capsys, folder):
    (folder / "log.mcap").unlink()
    assert cli.main(["log", str(folder)]) == 0
    rows = rows_of(capsys.readouterr().out)
    assert rows["com"] == ["m", "3", "101", "1000", rows["com"][4], "-"]


def test_log_writes_mcap_at_another_rate(capsys, folder):
    target = folder.parent / "new" / "full.mcap"
    assert cli.main(["log", str(folder), "--mcap", str(target), "--rate", "1000"]) == 0
    assert capsys.readouterr().out == f"{target}\n"
    assert target.read_bytes()[1:5] == b"MCAP"
    assert [path.name for path in target.parent.iterdir()] == ["full.mcap"]


@pytest.mark.parametrize("content", [b"", b"nonsense", b"\x89MCAP0\r\n" + bytes(20)])
def test_a_log_that_is_none_is_refused(capsys, folder, content):
    (folder / "log.mcap").write_bytes(content)
    assert "log.mcap: the log " in refuse(capsys, "log", str(folder))


def test_log_refuses_bad_words(capsys, folder):
    assert "nowhere/log.arrow" in refuse(capsys, "log", "nowhere")
    assert "Missing argument 'DIR'" in refuse(capsys, "log")
    assert "'--rate': needs --mcap" in refuse(capsys, "log", str(folder), "--rate", "50")
    target = folder / "x.mcap"
    for rate in ("0", "nan"):
        words = ("log", str(folder), "--mcap", str(target), "--rate", rate)
        assert "must be a number from 0.001 to 1e+06, in Hz" in refuse(capsys, *words)
    into = folder / "log.arrow" / "x.mcap"
    assert "cannot be written" in refuse(capsys, "log", str(folder), "--mcap", str(into))
    assert not target.exists()


# -------------------------------------------------------------------------------- drawings


def test_draw_writes_both_files(capsys, tmp_path):
    assert cli.main(["draw", "stand", "--out", str(tmp_path)]) == 0
    printed = capsys.readouterr().out.splitlines()
    assert printed == [str(tmp_path / "stand.txt"), str(tmp_path / "stand.svg")]
    committed = (diagrams_dir() / "stand.txt").read_text(encoding="utf-8")
    assert (tmp_path / "stand.txt").read_text(encoding="utf-8") == committed


def test_draw_writes_beside_the_scenario(tmp_path):
    (tmp_path / "mine.yaml").write_text("{}", encoding="utf-8")
    assert cli.main(["draw", str(tmp_path / "mine.yaml")]) == 0
    assert sorted(p.name for p in tmp_path.iterdir()) == ["mine.svg", "mine.txt", "mine.yaml"]


def test_draw_does_not_write_into_an_installed_package(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("drake_linefoot.lab.cli.inspect.PACKAGE", diagrams_dir())
    assert cli.main(["draw", "stand"]) == 0
    written = ["out/diagrams/stand.txt", "out/diagrams/stand.svg"]
    assert capsys.readouterr().out.splitlines() == written


def test_draw_writes_a_system_into_a_folder_of_its_own(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["draw", "gait_planner", "--of", "stand", "--png"]) == 0
    names = ["out/diagrams/gait_planner.svg", "out/diagrams/gait_planner.png"]
    assert capsys.readouterr().out.splitlines() == names
    assert all((tmp_path / name).stat().st_size > 1000 for name in names)


def test_ports_are_printed_and_nothing_is_written(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["draw", "controller.ecd_mpc", "--ports"]) == 0
    title, *sections = capsys.readouterr().out.split("\n## ")
    assert title.strip() == "# Ports of ecd_mpc"
    rows = {text.split("\n")[0]: re.findall(r"^\| `(\w+)`", text, re.M) for text in sections}
    signals = {
        kind.__name__: list(kind._fields) for kind in (RobotDynamics, Reference, CentroidalPlan)
    }
    assert rows == {"ecd_mpc": ["dynamics", "reference", "plan"], **signals}
    assert list(tmp_path.iterdir()) == []


# ------------------------------------------------------------------------------- the robot


def test_show_opens_the_robot(capsys):
    assert cli.main(["show", "mit_humanoid", "--loop-once"]) == 0
    out, err = capsys.readouterr()
    assert out.startswith("Live at http://")
    assert err == ""


@pytest.mark.parametrize("words", [["nobody"], ["nobody.yaml"], [""]])
def test_show_refuses_a_robot_that_is_not_there(capsys, words):
    said = refuse(capsys, "show", *words, "--loop-once")
    assert repr(words[0]) in said or words[0] in said
