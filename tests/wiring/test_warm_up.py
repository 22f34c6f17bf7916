"""Compiling before the first run; tests/test_packaging.py carries out all of it."""

import os
import subprocess
import sys

import pytest

from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.wiring import closed_loop
from drake_linefoot.math import compiled
from drake_linefoot.math.machine_code import complete
from drake_linefoot.wiring import warm_up as module
from drake_linefoot.wiring.controller import build_controller
from drake_linefoot.wiring.warm_up import MESSAGE, NOWHERE, ON_TWO, compile_first
from tests.helpers.small_biped import write_small_biped


@pytest.fixture(autouse=True)
def nothing_begun(monkeypatch):
    monkeypatch.setattr(module, "_BEGUN", set())


@pytest.fixture
def nothing_kept(monkeypatch, tmp_path):
    monkeypatch.setattr(module, "machine_code_is_kept", lambda: False)
    monkeypatch.setattr(module, "machine_code_folder", lambda: tmp_path)
    monkeypatch.setattr(module, "keep_machine_code", lambda: complete(tmp_path))
    monkeypatch.setattr(module, "compile_blocks", lambda way: None)
    monkeypatch.setattr(module, "_helper_command", list)
    return tmp_path


def test_it_does_nothing_when_machine_code_is_kept(monkeypatch, capfd):
    monkeypatch.setattr(module, "machine_code_is_kept", lambda: True)
    compile_first(lambda: pytest.fail("walked"))
    assert capfd.readouterr() == ("", "")


def test_machine_code_is_kept_when_it_is_in_its_folder(monkeypatch, tmp_path):
    monkeypatch.setattr(compiled.config, "CACHE_DIR", str(tmp_path))
    assert not compiled.machine_code_is_kept()
    folder = tmp_path / f"kernels-{compiled._DIGEST}" / "math"
    folder.mkdir(parents=True)  # which an import makes
    assert not compiled.machine_code_is_kept()
    (folder / "kernels.dot-1.py311.1.nbc").touch()  # one function, of a run that broke off
    assert not compiled.machine_code_is_kept()
    compiled.keep_machine_code()
    assert compiled.machine_code_is_kept()


def test_machine_code_is_kept_when_a_wheel_brought_all_of_it(monkeypatch, tmp_path):
    monkeypatch.setattr(compiled, "machine_code_folder", lambda: None)
    monkeypatch.setattr(compiled, "_shipped", lambda: tmp_path)
    assert not compiled.machine_code_is_kept()
    complete(tmp_path)
    assert compiled.machine_code_is_kept()


def test_it_says_once_what_it_does_on_stderr_alone(nothing_kept, capfd):
    walks = []

    def walk():
        walks.append("walk")
        compile_first(walk)  # as the loop does that it builds

    compile_first(walk)
    compile_first(walk)
    assert walks == ["walk"]
    assert capfd.readouterr() == ("", f"{MESSAGE}\n")
    assert [path.name for path in nothing_kept.iterdir()] == ["complete"]


def test_in_a_terminal_there_is_a_bar_while_it_compiles(nothing_kept, monkeypatch, capfd):
    monkeypatch.setenv("FORCE_COLOR", "1")  # a terminal, for Rich
    monkeypatch.setenv("TERM", "xterm")
    compile_first(lambda: None)
    said = capfd.readouterr()
    assert said.out == ""
    assert said.err.startswith(f"{MESSAGE}\n")
    assert "━" in said.err and "0:00:00" in said.err


def test_in_a_notebook_there_is_a_bar_without_widgets(nothing_kept, monkeypatch, capfd):
    monkeypatch.setattr("rich.console._is_jupyter", lambda: True)
    with module._bar("compiling") as progress:
        progress(0.25)
        progress(0.5)
    out, err = capfd.readouterr()  # where IPython shows things without a notebook
    assert err == "compiling\n"
    assert [line.split()[-1] for line in out.splitlines()] == ["0/100", "25/100", "50/100"]


def test_a_walk_that_breaks_off_keeps_nothing_and_is_walked_again(nothing_kept):
    def stop():
        raise KeyboardInterrupt

    for _ in range(2):
        with pytest.raises(KeyboardInterrupt):
            compile_first(stop)
    assert list(nothing_kept.iterdir()) == []


def test_where_nothing_can_be_kept_it_says_so_and_what_helps(nothing_kept, monkeypatch, capfd):
    monkeypatch.setattr(module, "machine_code_folder", lambda: None)
    monkeypatch.setattr(module, "_helper_command", lambda: pytest.fail("nothing to share"))
    compile_first(lambda: None)
    assert capfd.readouterr().err == f"{NOWHERE}\n"
    assert "NUMBA_CACHE_DIR" in NOWHERE
    monkeypatch.undo()
    monkeypatch.setattr(compiled, "machine_code_folder", lambda: None)
    compiled.keep_machine_code()  # does no harm


def test_interpreted_there_is_nothing_to_compile(monkeypatch, tmp_path):
    monkeypatch.setattr(compiled.config, "CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(compiled.config, "DISABLE_JIT", 1)
    assert compiled.machine_code_is_kept()


def test_a_second_process_compiles_beside_and_its_functions_are_counted(
    nothing_kept, monkeypatch, capfd
):
    said = "import time; print('one', 'two', sep=chr(10), flush=True); time.sleep(100)"
    monkeypatch.setattr(module, "_helper_command", lambda: [sys.executable, "-c", said])
    ways, shares = [], []
    monkeypatch.setattr(module, "compile_blocks", ways.append)
    progress = shares.append
    with module._helped(module._helper_command(), progress):
        while len(shares) < 2:
            pass
    assert shares == pytest.approx([compiled.share_of_all(range(n)) for n in (1, 2)])
    compile_first(lambda: None)
    assert ways == [1]
    assert capfd.readouterr().err == f"{ON_TWO}\n"


@pytest.mark.parametrize(
    ("cores", "python", "starts"),
    [
        (2, sys.executable, True),
        (1, sys.executable, False),
        (2, "/usr/bin/blender", False),
        (2, "", False),
        (2, None, False),
    ],
)
def test_there_is_a_second_process_where_it_helps(monkeypatch, cores, python, starts):
    monkeypatch.setattr(module.os, "sched_getaffinity", lambda _: set(range(cores)), raising=False)
    monkeypatch.setattr(module.os, "cpu_count", lambda: cores)
    monkeypatch.setattr(module.sys, "executable", python)
    assert bool(module._helper_command()) == starts


@pytest.mark.parametrize("quiet", ["test", "worker", ""])
def test_the_first_build_compiles_first_but_in_tests_and_workers(monkeypatch, quiet):
    class EnoughError(Exception):
        pass

    def enough(walk):
        assert walk is closed_loop._walk_a_little
        raise EnoughError

    if quiet != "test":
        monkeypatch.delenv("PYTEST_CURRENT_TEST")
    monkeypatch.setattr(module, "parent_process", lambda: quiet == "worker" or None)
    monkeypatch.setattr(closed_loop, "compile_first", enough)
    if quiet:
        closed_loop.build_closed_loop(Scenario())
    else:
        with pytest.raises(EnoughError):
            closed_loop.build_closed_loop(Scenario())


@pytest.mark.parametrize("quiet", ["test", "worker", ""])
def test_so_does_a_controller_that_is_built_alone(monkeypatch, humanoid, quiet):
    walked = []
    if quiet != "test":
        monkeypatch.delenv("PYTEST_CURRENT_TEST")
    monkeypatch.setattr(module, "parent_process", lambda: quiet == "worker" or None)
    monkeypatch.setattr(module, "machine_code_is_kept", lambda: False)
    monkeypatch.setattr(module, "compile_first", walked.append)
    build_controller(humanoid)
    assert len(walked) == (not quiet)
    if walked:
        monkeypatch.setattr(module, "compile_first", lambda walk: None)  # as in the walk itself
        walked[0]()


# In a process of its own: what other tests have compiled does not count.
WALKS = """
import sys
from numba.core.event import install_recorder
from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop, warm_up
segments = [Segment("stand", 0.02), Segment("walk", 2.0, walk=True, velocity=[0.2, 0.0])]
warm_up()
with install_recorder("numba:compile") as recorder:
    for file in sys.argv[1:]:
        loop = build_closed_loop(Scenario(robot=file, segments=segments))
        simulator = loop.make_simulator()
        simulator.AdvanceTo(0.9)
        assert simulator.get_context().get_time() == 0.9
        print(loop.humanoid.na)
print(*[event.data["dispatcher"] for _, event in recorder.buffer])
"""


@pytest.mark.slow
@pytest.mark.skipif(compiled.config.DISABLE_JIT, reason="nothing is compiled")
def test_a_robot_of_another_size_compiles_nothing_anew(tmp_path):
    """The warm-up of the robot that is shipped, of 18 motors, is that of all."""
    files = []
    for arms in (False, True):
        (tmp_path / str(arms)).mkdir()
        files.append(str(write_small_biped(tmp_path / str(arms), arms)))
    done = subprocess.run(
        [sys.executable, "-c", WALKS, *files],
        env=os.environ,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    *motors, names = done.stdout.splitlines()
    assert motors == ["10", "14"]
    assert names == ""
