"""`from drake_linefoot import ...`: what there is, how it is loaded, what a type checker sees."""

import ast
import importlib
import inspect
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import drake_linefoot
from drake_linefoot import Scenario, Segment, build_closed_loop, simulate, walk

ROOT = Path(__file__).resolve().parents[1]
STUB = ROOT / "drake_linefoot" / "__init__.pyi"
FACE = {
    *("Scenario", "Segment", "load_humanoid", "ControllerParameters", "build_controller"),
    "Controller",
    *("build_closed_loop", "simulate", "walk", "Run"),
}
LAB = {"Run", "build_closed_loop", "simulate", "walk"}  # of these, what needs more packages


def in_the_stub():
    """Name -> the module that the stub takes it from."""
    nodes = ast.parse(STUB.read_text(encoding="utf-8")).body
    imports = [node for node in nodes if isinstance(node, ast.ImportFrom)]
    assert all(alias.asname == alias.name for node in imports for alias in node.names)
    return {alias.name: node.module for node in imports for alias in node.names}


def said_by(code):
    run = [sys.executable, "-c", code]
    done = subprocess.run(run, cwd=ROOT, capture_output=True, text=True, timeout=120, check=True)
    return done.stdout.splitlines()


def test_the_names_are_there_and_shown():
    assert set(dir(drake_linefoot)) >= FACE
    for name in FACE:
        assert getattr(drake_linefoot, name).__name__ == name


def test_the_stub_has_these_names_and_what_they_are():
    stub = in_the_stub()
    assert set(stub) == FACE
    for name, module in stub.items():
        assert getattr(importlib.import_module(module), name) is getattr(drake_linefoot, name)


def test_another_name_is_no_attribute():
    with pytest.raises(AttributeError, match="has no attribute 'wlak'"):
        drake_linefoot.wlak  # noqa: B018
    with pytest.raises(ImportError, match="cannot import name 'wlak'"):
        exec("from drake_linefoot import wlak")


def test_nothing_is_loaded_before_it_is_asked_for():
    code = (
        "import sys, drake_linefoot\n"
        "assert 'walk' in dir(drake_linefoot)\n"
        "loaded = {name.partition('.')[0] for name in sys.modules}\n"
        "print(loaded & {'numpy', 'numba', 'pydantic', 'pydrake', 'scipy', 'pyarrow'})\n"
        "print([name for name in sys.modules if name.startswith('drake_linefoot.')])"
    )
    first, second = said_by(code)
    assert first == "set()"
    assert (
        second == "['drake_linefoot._environment', 'drake_linefoot.errors', 'drake_linefoot.late']"
    )


def test_help_shows_signature_and_meaning():
    for name in FACE:
        found = getattr(drake_linefoot, name)
        assert inspect.signature(found).parameters
        assert len(inspect.getdoc(found)) > 40
    assert [*inspect.signature(walk).parameters] == [
        *("vx", "vy", "turn_rate", "duration", "robot", "fields")
    ]


def test_without_the_laboratory_a_name_of_it_says_what_to_install():
    code = (
        "import sys\n"
        "for name in ('pyarrow', 'typer', 'rich', 'tornado', 'matplotlib', 'trimesh'):\n"
        "    sys.modules[name] = None\n"
        "from drake_linefoot import ControllerParameters, build_controller, load_humanoid\n"
        "import drake_linefoot\n"
        f"for name in {sorted(LAB)}:\n"
        "    try:\n"
        "        getattr(drake_linefoot, name)\n"
        "    except ImportError as error:\n"
        "        print(error)\n"
    )
    said = said_by(code)
    assert len(said) == len(LAB)
    for name, line in zip(sorted(LAB), said, strict=True):
        assert line.startswith(f"drake_linefoot.{name} needs ")
        assert line.endswith("pip install 'drake_linefoot[lab]'")


@pytest.mark.slow
def test_a_walk_in_one_call_is_the_same_as_in_four():
    run = walk(0.4, 0.1, 0.2, duration=1.0, seed=3)
    assert not run.fell
    assert run.scenario.seed == 3
    segments = [
        Segment("stand", 0.5),
        Segment("walk", 1.0, walk=True, velocity=[0.4, 0.1], turn_rate=0.2),
        Segment("stop", 2.0),
    ]
    again = simulate(build_closed_loop(Scenario(seed=3, segments=segments)))
    np.testing.assert_array_equal(run.q, again.q)
    forward, left = run.com[-1, :2] - run.com[0, :2]
    assert forward > 0.2 and left > 0.05
    assert run.planned_contact[-1].all()  # it has stopped


def test_a_walk_refuses_what_a_scenario_has_not(tmp_path):
    with pytest.raises(TypeError, match="speed"):
        walk(speed=1.0)
    with pytest.raises(ValueError, match="unknown robot; must be one of"):
        walk(robot="nobody")
    with pytest.raises(ValueError, match="one description"):
        walk(robot=tmp_path)


USER = """
from drake_linefoot import (
    ControllerParameters, Run, Scenario, Segment, build_closed_loop, build_controller,
    load_humanoid, simulate, walk,
)

run: Run = walk(vx=0.4, duration=2.0, seed=1)
scenario = Scenario(segments=[Segment("walk", 3.0, walk=True, velocity=[0.5, 0.0])])
loop = build_closed_loop(scenario, controller=build_controller(load_humanoid(scenario.robot)))
again: Run = simulate(loop)
parameters = ControllerParameters(period=0.002)
height: float = run.com[-1, 2]
"""
WRONG = """
walk(vx="fast")
Scenario(segments=1)
simulate(scenario)
from drake_linefoot import wlak
"""


@pytest.mark.slow
def test_a_type_checker_sees_what_the_names_are(tmp_path):
    file = tmp_path / "user.py"
    file.write_text(USER + WRONG, encoding="utf-8")
    mypy = [sys.executable, "-m", "mypy", "--strict", "--follow-imports=silent", str(file)]
    environment = {"MYPYPATH": str(ROOT), "PATH": ""}
    done = subprocess.run(
        mypy, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    found = [line.split(": error: ") for line in done.stdout.splitlines() if ": error: " in line]
    lines = USER.count("\n")
    assert [int(place.split(":")[1]) - lines for place, _ in found] == [2, 3, 4, 5], done.stdout
