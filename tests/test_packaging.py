"""The wheel holds the package, the models and the scenarios, and runs on its own."""

import json
import os
import shutil
import subprocess
import sys
import sysconfig
import tomllib
import zipfile
from pathlib import Path, PurePosixPath

import pytest

import drake_linefoot

ROOT = Path(__file__).resolve().parents[1]
SOURCES = ("pyproject.toml", "README.md", "LICENSE", "drake_linefoot", "models", "diagrams")
MODEL_SUFFIXES = {
    *(".urdf", ".sdf", ".xml", ".yaml"),
    *(".obj", ".mtl", ".gltf", ".glb", ".bin", ".png"),
    *(".md", ".txt"),
}


def run(*command, **options):
    """Run a command, return its output; say what it printed when it fails."""
    command = [str(word) for word in command]
    done = subprocess.run(command, capture_output=True, text=True, check=False, **options)
    assert done.returncode == 0, f"{' '.join(command)}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def build(source, out):
    """Build a wheel with this environment's setuptools, or else with one pip fetches."""
    here = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "-o", out, source]
    if subprocess.run(here, capture_output=True, check=False).returncode != 0:
        run(sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "-w", out, source)


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """The wheel, built from a copy: a build leaves folders behind."""
    folder = tmp_path_factory.mktemp("wheel")
    source = folder / "source"
    source.mkdir()
    for name in SOURCES:
        if (ROOT / name).is_dir():
            ignored = shutil.ignore_patterns("__pycache__", "*.pyc")
            shutil.copytree(ROOT / name, source / name, ignore=ignored)
        else:
            shutil.copy(ROOT / name, source / name)
    build(source, folder / "dist")
    (path,) = (folder / "dist").glob("*.whl")
    return path


@pytest.fixture(scope="module")
def content(wheel):
    """Paths of the wheel's files, in two sets: the package's and the metadata's."""
    with zipfile.ZipFile(wheel) as archive:
        names = [name for name in archive.namelist() if not name.endswith("/")]
    metadata = {name for name in names if name.split("/")[0].endswith(".dist-info")}
    return set(names) - metadata, metadata


def tree(folder, pattern="*"):
    """Paths of the files under `folder` of the checkout, relative to it."""
    paths = (path.relative_to(ROOT / folder) for path in (ROOT / folder).rglob(pattern))
    visible = (path for path in paths if not any(part.startswith(".") for part in path.parts))
    return {path.as_posix() for path in visible if (ROOT / folder / path).is_file()}


def test_every_folder_of_the_package_is_listed():
    with (ROOT / "pyproject.toml").open("rb") as file:
        listed = set(tomllib.load(file)["tool"]["setuptools"]["packages"])
    folders = {path.parent.relative_to(ROOT) for path in ROOT.glob("drake_linefoot/**/*.py")}
    expected = {".".join(folder.parts) for folder in folders}
    assert listed == expected | {"drake_linefoot.models", "drake_linefoot.diagrams"}


def test_every_folder_of_the_package_has_an_init():
    folders = {path.parent for path in ROOT.glob("drake_linefoot/**/*.py")}
    assert [folder for folder in folders if not (folder / "__init__.py").is_file()] == []


def test_wheel_holds_the_package_models_and_scenarios_and_nothing_else(content):
    package, _ = content
    assert package == {
        "drake_linefoot/py.typed",
        *(f"drake_linefoot/{path}" for path in tree("drake_linefoot", "*.py")),
        *(f"drake_linefoot/{path}" for path in tree("drake_linefoot", "*.j2")),
        *(f"drake_linefoot/models/{path}" for path in tree("models")),
        *(f"drake_linefoot/diagrams/{path.name}" for path in ROOT.glob("diagrams/*.yaml")),
    }


def test_wheel_holds_the_robot_its_meshes_and_a_scenario(content):
    package = {PurePosixPath(name) for name in content[0]}
    models = PurePosixPath("drake_linefoot/models")
    assert models / "package.xml" in package
    assert any(path.match("drake_linefoot/models/*/*.urdf") for path in package)
    assert any(path.match("drake_linefoot/models/*/*.yaml") for path in package)
    assert any(path.match("drake_linefoot/models/*/meshes/*") for path in package)
    assert any(path.match("drake_linefoot/diagrams/*.yaml") for path in package)


def test_models_are_data_of_known_kinds():
    odd = {path for path in tree("models") if PurePosixPath(path).suffix not in MODEL_SUFFIXES}
    assert {path for path in odd if PurePosixPath(path).name != "LICENSE"} == set()


def test_metadata_names_version_command_and_licence(wheel, content):
    with zipfile.ZipFile(wheel) as archive:
        text = {PurePosixPath(n).name: archive.read(n).decode() for n in content[1]}
    assert f"\nVersion: {drake_linefoot.__version__}\n" in text["METADATA"]
    assert "linefoot = drake_linefoot.cli:main" in text["entry_points.txt"]
    assert text["LICENSE"] == (ROOT / "LICENSE").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory):
    """A fresh environment with the wheel in it; its dependencies are this environment's.

    A .pth file lends them, written after the installation so that pip sees an empty
    environment. A .pth inside a lent folder is not read: no editable install comes along.
    """
    home = tmp_path_factory.mktemp("environment") / "venv"
    run(sys.executable, "-m", "venv", "--without-pip", home)
    pip = (sys.executable, "-m", "pip", "--python", home / "bin" / "python")
    run(*pip, "install", "--quiet", "--no-deps", "--no-index", wheel)
    paths = {"base": str(home), "platbase": str(home)}
    lent = {sysconfig.get_path("purelib"), sysconfig.get_path("platlib")}
    site = Path(sysconfig.get_path("purelib", vars=paths))
    (site / "lent.pth").write_text("\n".join(sorted(lent)), encoding="utf-8")
    return home / "bin"


@pytest.fixture
def elsewhere(tmp_path):
    """Keywords of a process in an empty folder, with nothing pointing to the checkout."""
    folder = tmp_path / "empty"
    folder.mkdir()
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    return {"cwd": folder, "env": environment, "timeout": 600}


def test_installed_wheel_finds_its_own_models_and_scenarios(installed, elsewhere):
    code = (
        "from drake_linefoot import resources as r; import json;"
        "print(json.dumps([str(p()) for p in (r.models_dir, r.diagrams_dir)]))"
    )
    for path in json.loads(run(installed / "python", "-c", code, **elsewhere)):
        assert Path(path).is_relative_to(installed.parent)
        assert "site-packages" in path


@pytest.mark.slow
def test_installed_wheel_walks_from_an_empty_folder(installed, elsewhere, tmp_path):
    out = tmp_path / "out"
    run(installed / "linefoot", "walk", "--duration", "0.3", "--out", out, **elsewhere)
    assert json.loads((out / "metrics.json").read_text(encoding="utf-8"))
    assert list(elsewhere["cwd"].iterdir()) == []
