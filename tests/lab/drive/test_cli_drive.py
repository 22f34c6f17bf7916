"""The command `linefoot drive`."""

import json
import os
import signal
import socket
import tempfile

import pytest
from pydrake.geometry import Meshcat, MeshcatParams

from drake_linefoot.lab import cli
from drake_linefoot.lab.drive.session import Session
from drake_linefoot.lab.simulation.recording import Run


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--port", "0"), "'--port': '0' must be a whole number from 1 to 65535"),
        (("--port", "70000"), "'--port': '70000' must be a whole number"),
        (("--duration", "-1"), "'--duration': '-1' must be a number above 0, in s"),
        (("--model", "lip"), "'--model': 'lip' must be one of ['ecd', 'contact_consistent', "),
        (("--simulator", "bullet"), "command line: plant.simulator = 'bullet': must be one of"),
        (("--simulator", ""), "command line: plant.simulator = '': must be one of"),
        (("nowhere.yaml",), "scenario = 'nowhere.yaml': no such file"),
    ],
)
def test_bad_words_are_refused(capsys, words, said):
    assert cli.main(["drive", *words]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert said in err
    assert err.count("\n") == 1


def test_a_taken_port_is_refused(capsys):
    meshcat = Meshcat(MeshcatParams(port=0))
    assert cli.main(["drive", "--port", str(meshcat.port())]) == 2
    expected = f"linefoot: --port = {meshcat.port()}: is taken, or not allowed\n"
    assert capsys.readouterr().err == expected


def test_a_session_is_written_like_any_run(capsys, tmp_path):
    with socket.socket() as free:
        free.bind(("", 0))
        port = free.getsockname()[1]
    out = tmp_path / "out"
    words = ["drive", "--duration", "0.5", "--port", str(port), "--out", str(out)]
    assert cli.main(words) == 0
    first, press, last = capsys.readouterr().out.splitlines()
    assert first.startswith(f"Drive at http://localhost:{port}")
    assert first.endswith("/view/")
    assert press == "W walks, Q and E turn it, X stops it, P pushes it; Ctrl-C here ends it"
    assert last == str(out / "replay.html")
    assert json.loads((out / "metrics.json").read_text())["duration_s"] > 0.0  # of real time
    assert {p.name for p in out.iterdir()} >= {"replay.html", "log.arrow", "plots", "metrics.json"}


def test_it_is_driven_in_another_simulator(capsys, tmp_path):
    pytest.importorskip("mujoco", reason="MuJoCo is not installed: the extra mujoco")
    words = ["drive", "--duration", "0.3", "--simulator", "mujoco", "--out", str(tmp_path / "out")]
    assert cli.main(words) == 0
    assert Run.load(tmp_path / "out").scenario.plant.simulator == "mujoco"


def test_sigterm_writes_the_session(capsys, tmp_path, monkeypatch):
    advance, looks = Session.advance, []

    def terminated(self, length):
        looks.append(1)
        advance(self, length)
        if len(looks) == 5:
            os.kill(os.getpid(), signal.SIGTERM)

    monkeypatch.setattr(Session, "advance", terminated)
    assert cli.main(["drive", "--duration", "60", "--out", str(tmp_path / "out")]) == 143
    out, err = capsys.readouterr()
    assert err == "linefoot: terminated\n"
    assert out.splitlines()[-1] == str(tmp_path / "out")
    assert Run.load(tmp_path / "out").time[-1] == pytest.approx(5 / 32, abs=0.01)


def test_an_error_that_nobody_foresaw_leaves_the_session_written(capsys, tmp_path, monkeypatch):
    advance, looks = Session.advance, []

    def fail(self, length):
        looks.append(1)
        advance(self, length)
        if len(looks) == 5:
            raise SystemExit("an assertion of Drake")

    monkeypatch.setattr(Session, "advance", fail)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    assert cli.main(["drive", "--duration", "60", "--out", str(tmp_path / "out")]) == 3
    assert "unexpected error, SystemExit: an assertion of Drake (" in capsys.readouterr().err
    assert Run.load(tmp_path / "out").time[-1] == pytest.approx(5 / 32, abs=0.01)


def test_it_is_opened_to_others_only_when_asked(capsys):
    assert cli.main(["drive", "--duration", "0.1", "--host", "0.0.0.0"]) == 0
    first, _, second = capsys.readouterr().out.splitlines()
    assert socket.gethostname() in first
    assert second.startswith("Other machines reach it, too")
    assert cli.main(["drive", "--duration", "0.1", "--port", "22"]) == 2
    assert capsys.readouterr().err == "linefoot: --port = 22: must be 1024 or more\n"


def test_a_robot_that_lies_on_the_ground_at_the_end_is_status_1(capsys, monkeypatch):
    monkeypatch.setattr(Session, "advance", lambda self, _: setattr(self, "fall", "torso low"))
    assert cli.main(["drive", "--duration", "0.2"]) == 1
    assert "The robot FELL at 0.000 s: torso low" in capsys.readouterr().out
