"""The command `linefoot drive`."""

import json
import socket

import pytest
from pydrake.geometry import Meshcat, MeshcatParams

from drake_linefoot import cli
from drake_linefoot.drive.session import Session


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--port", "0"), "'--port': '0' must be a whole number from 1 to 65535"),
        (("--port", "70000"), "'--port': '70000' must be a whole number"),
        (("--duration", "-1"), "'--duration': '-1' must be a number above 0, in s"),
        (("--model", "lip"), "'--model': 'lip' must be one of ['ecd', 'srbm']"),
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
    first, last = capsys.readouterr().out.splitlines()
    assert first.startswith(f"Drive at http://localhost:{port}")
    assert last == str(out / "replay.html")
    assert json.loads((out / "metrics.json").read_text())["duration_s"] > 0.0  # of real time
    assert {p.name for p in out.iterdir()} >= {"replay.html", "log.npz", "plots", "metrics.json"}


def test_a_robot_that_lies_on_the_ground_at_the_end_is_status_1(capsys, monkeypatch):
    monkeypatch.setattr(Session, "advance", lambda self, _: setattr(self, "fall", "torso low"))
    assert cli.main(["drive", "--duration", "0.2"]) == 1
    assert "The robot FELL at 0.000 s: torso low" in capsys.readouterr().out
