"""The wheel holds the package, the models and the scenarios, and runs on its own.

Where it is installed, its first walk compiles what is not kept yet, and is compared with walks by
machine code that is.
"""

import json
import os
import re
import runpy
import shutil
import subprocess
import sys
import tomllib
import xml.etree.ElementTree as ET
import zipfile
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory

import pytest
import yaml

from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.sweep.file import load_sweep
from drake_linefoot.lab.sweep.jobs import jobs
from drake_linefoot.lab.sweep.worker import carry_out
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.math.compiled import machine_code_folder
from drake_linefoot.math.machine_code import COMPLETE
from tests.helpers.tiny_sweeps import write_sweep
from tests.lab.simulation.test_run import RANDOM, digest

ROOT = Path(__file__).resolve().parents[1]
SOURCES = ("pyproject.toml", "README.md", "LICENSE", "drake_linefoot", "models", "diagrams")
MODEL_SUFFIXES = {
    *(".urdf", ".sdf", ".xml", ".yaml"),
    *(".obj", ".mtl", ".gltf", ".glb", ".bin", ".png"),
    *(".md", ".txt"),
}


VERSION = "9.8.7"  # as if that were the tag
PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
RELEASE = PYPROJECT["tool"]["setuptools_scm"]["fallback_version"]
NEXT = re.sub(r"\d+$", lambda patch: str(int(patch[0]) + 1), RELEASE)
RELEASING = runpy.run_path(str(ROOT / "tools" / "make_wheel.py"))
PRETEND = os.environ | {"SETUPTOOLS_SCM_PRETEND_VERSION_FOR_DRAKE_LINEFOOT": VERSION}


def run(*command, **options):
    """Run a command, return its output; say what it printed when it fails."""
    command = [str(word) for word in command]
    done = subprocess.run(command, capture_output=True, text=True, check=False, **options)
    assert done.returncode == 0, f"{' '.join(command)}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def build(source, out, *kinds, env=None):
    """Build with this environment's setuptools."""
    run(sys.executable, "-m", "build", *kinds, "--no-isolation", "-o", out, source, env=env)


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
    build(source, folder / "dist", "--sdist", "--wheel", env=PRETEND)
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
        "drake_linefoot/__init__.pyi",
        *(f"drake_linefoot/{path}" for path in tree("drake_linefoot", "*.py")),
        *(f"drake_linefoot/{path}" for path in tree("drake_linefoot", "*.j2")),
        *(f"drake_linefoot/{path}" for path in tree("drake_linefoot", "web/*")),
        *(f"drake_linefoot/{path}" for path in tree("drake_linefoot", "*.lcm")),
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
    assert f"\nVersion: {VERSION}\n" in text["METADATA"]
    assert "linefoot = drake_linefoot.__main__:main" in text["entry_points.txt"]
    assert text["LICENSE"] == (ROOT / "LICENSE").read_text(encoding="utf-8")


def test_wheel_and_sdist_are_what_an_index_takes(wheel):
    files = sorted(wheel.parent.iterdir())
    assert [path.name.split("-")[1][:5] for path in files] == [VERSION, VERSION]
    said = run(sys.executable, "-m", "twine", "check", "--strict", *files)
    assert said.count("PASSED") == 2


def test_an_sdist_builds_a_wheel_of_its_own_version_with_the_same_files(wheel, content, tmp_path):
    (sdist,) = wheel.parent.glob("*.tar.gz")
    run(sys.executable, "-m", "tarfile", "-e", sdist, tmp_path)  # alike in every Python
    source = next(tmp_path.iterdir())
    build(source, tmp_path / "dist", "--wheel")
    (again,) = (tmp_path / "dist").glob("*.whl")
    assert again.name == wheel.name
    with zipfile.ZipFile(again) as archive:
        names = {name for name in archive.namelist() if not name.endswith("/")}
    assert {name for name in names if ".dist-info/" not in name} == content[0]


def test_every_file_names_the_last_release():
    heading = re.compile(r"^## \[(\d.*)\] - (\d{4}-\d\d-\d\d)$", re.MULTILINE)
    version, date = heading.search((ROOT / "CHANGELOG.md").read_text(encoding="utf-8")).groups()
    assert version == RELEASE
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert (cited["version"], str(cited["date-released"])) == (version, date)
    assert ET.parse(ROOT / "models" / "package.xml").findtext("version") == version


@pytest.mark.parametrize(
    ("tag", "commits", "version"),
    [("v3.2.1", 0, "3.2.1"), ("v3.2.1", 1, "3.2.2.dev1"), ("", 2, f"{NEXT}.dev3")],
)
def test_the_version_is_that_of_the_tag(tmp_path, tag, commits, version):
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    who = ("-c", "user.name=t", "-c", "user.email=t@example.org", "-c", "commit.gpgsign=false")
    git = ("git", "-C", tmp_path)
    run(*git, "init", "--quiet")
    run(*git, "add", ".")
    run(*git, *who, "commit", "--quiet", "-m", "first")
    if tag:
        run(*git, "tag", tag)
    for _ in range(commits):
        run(*git, *who, "commit", "--quiet", "--allow-empty", "-m", "next")
    assert run(sys.executable, "-m", "setuptools_scm", "--root", tmp_path).strip() == version


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory):
    """A fresh environment with the wheel in it; its dependencies are this environment's."""
    home = tmp_path_factory.mktemp("environment") / "venv"
    return RELEASING["environment_with"](wheel, home).parent


@pytest.fixture
def elsewhere(tmp_path):
    """Keywords of a process in an empty folder, with nothing pointing to the checkout."""
    folder = tmp_path / "empty"
    folder.mkdir()
    without = ("PYTHONPATH", "NUMBA_CACHE_DIR")
    environment = {name: value for name, value in os.environ.items() if name not in without}
    return {"cwd": folder, "env": environment, "timeout": 600}


def test_installed_wheel_finds_its_own_models_and_scenarios(installed, elsewhere):
    code = (
        "from drake_linefoot import resources as r; import json;"
        "from drake_linefoot import __version__ as v;"
        "print(json.dumps([v, *[str(p()) for p in (r.models_dir, r.diagrams_dir)]]))"
    )
    version, *folders = json.loads(run(installed / "python", "-c", code, **elsewhere))
    assert version == VERSION
    for path in folders:
        assert Path(path).is_relative_to(installed.parent)
        assert "site-packages" in path


# --- compiled, and kept ----------------------------------------------------------------------

LACKS = "drake_linefoot.estimation.momentum_observer"  # the module whose machine code is made anew

TURNING = Scenario(
    segments=[Segment("stand", 0.1), Segment("walk", 1.5, True, [0.4, 0.1], turn_rate=0.4)]
)
# The command, and then in the same process a run of a sweep, a random start and a walk in a turn.
WALKS = """
import json, runpy, sys
command, checkout, *words = sys.argv[1:]
sys.argv = [command, *words]
try:
    runpy.run_path(command, run_name="__main__")
except SystemExit as end:
    status = end.code
import drake_linefoot
sys.path.append(checkout)
from tests.test_packaging import RANDOM, TURNING, build_closed_loop, digest, hash_of_sweep, simulate
print(json.dumps({
    "status": status,
    "package": drake_linefoot.__file__,
    "hash": hash_of_sweep(),
    "digest": digest(simulate(build_closed_loop(RANDOM))),
    "fell": simulate(build_closed_loop(TURNING)).fell,
}))
"""


def hash_of_sweep():
    """What a worker of a sweep says of a run."""
    with TemporaryDirectory() as folder:
        return carry_out(next(jobs(load_sweep(write_sweep(Path(folder))))))[0]["state_hash"]


@pytest.fixture
def walk(elsewhere, tmp_path):
    """Walk by the command of an environment; return what it said, and the numbers of WALKS."""

    def walked(where, *words):
        words = "walk", "--duration", "0.3", "--out", tmp_path / "out", *words
        code = where / "python", "-c", WALKS, where / "linefoot", ROOT, *words
        command = [str(word) for word in code]
        done = subprocess.run(command, **elsewhere, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        assert json.loads((tmp_path / "out" / "metrics.json").read_text(encoding="utf-8"))
        return done.stderr, json.loads(done.stdout.splitlines()[-1])

    return walked


@pytest.mark.slow
def test_installed_wheel_compiles_what_it_lacks_and_walks_the_same_from_an_empty_folder(
    installed, elsewhere, walk
):
    """What compiles has the bits of what finds it compiled, here and in the checkout.

    It lacks one block of what was compiled before the first test: all of it would take minutes.
    That a wheel with machine code compiles nothing, and walks with the same bits, is what
    `make wheel` says of each one that it makes; tests/math/test_machine_code.py tries how it does.
    """
    (package,) = installed.parent.glob("lib/*/site-packages/drake_linefoot")
    made = package / "__pycache__" / machine_code_folder().name
    shutil.rmtree(made, ignore_errors=True)  # of a drawing, which compiles a part
    first = (machine_code_folder() / COMPLETE).stat().st_mtime_ns
    for file in machine_code_folder().rglob("*.nb?"):
        # Indices are written anew with each kind of arguments, also those that tests came with.
        walks = file.suffix == ".nbi" or file.stat().st_mtime_ns <= first
        if walks and file.parent.name != LACKS:
            place = made / file.relative_to(machine_code_folder())
            place.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(file, place)
    copied = {*made.rglob("*.nbc")}
    assert len(copied) > 20
    said, anew = walk(installed, "--no-replay")  # whose drawings compile two more
    assert said.startswith("Compiling")
    new = {*made.rglob("*.nbc")} - copied
    assert {path.parent.name for path in new} == {LACKS}
    complete = (made / COMPLETE).stat().st_mtime_ns  # the end of what it said
    assert max(path.stat().st_mtime_ns for path in new) <= complete  # no walk compiles more
    said, kept = walk(installed)
    assert said == ""
    assert anew == kept
    assert Path(kept["package"]).is_relative_to(installed.parent)
    assert (kept["status"], kept["fell"]) == (0, False)
    assert kept["digest"] == digest(simulate(build_closed_loop(RANDOM)))
    assert kept["hash"] == hash_of_sweep()
    assert list(elsewhere["cwd"].iterdir()) == []


def test_a_wheel_with_machine_code_names_what_it_is_for_and_lists_it(wheel, content, tmp_path):
    made = tmp_path / "kernels-1"
    made.mkdir()
    source = Path(shutil.copy(wheel, tmp_path))
    with pytest.raises(ValueError, match="lacks machine code"):
        RELEASING["with_machine_code"](source, made)
    (made / "complete").touch()
    (made / "drake_linefoot.math").mkdir()
    (made / "drake_linefoot.math" / "one.nbc").write_bytes(b"code")
    (made / "drake_linefoot.math" / "one.nbc.tmp.1").write_bytes(b"co")  # half-written
    full = RELEASING["with_machine_code"](source, made)
    python = f"cp{sys.version_info[0]}{sys.version_info[1]}"
    tag = f"{python}-none-manylinux_2_17_x86_64"
    assert full.name == f"drake_linefoot-{VERSION}-{tag}.whl"
    with zipfile.ZipFile(full) as archive:
        assert archive.testzip() is None
        names = set(archive.namelist())
        (about,) = (name for name in names if name.endswith(".dist-info/WHEEL"))
        assert f"\nTag: {tag}\n" in archive.read(about).decode()
        record = archive.read(about.replace("WHEEL", "RECORD")).decode()
    brought = {
        f"drake_linefoot/kernels-1/{name}" for name in ("complete", "drake_linefoot.math/one.nbc")
    }
    assert names == content[0] | content[1] | brought
    assert {line.split(",")[0] for line in record.splitlines()} == names
    run(sys.executable, "-m", "twine", "check", "--strict", full)
    with pytest.raises(ValueError, match="is not for py3-none-any"):
        RELEASING["with_machine_code"](full, made)


def test_installed_wheel_draws_into_the_folder_it_is_called_from(installed, elsewhere):
    def files():
        found = (installed.parent / "lib").rglob("drake_linefoot/**/*")
        return {path for path in found if path.is_file() and "__pycache__" not in path.parts}

    before = files()
    elsewhere["env"]["NUMBA_CACHE_DIR"] = str(machine_code_folder().parent)  # nothing to compile
    said = run(installed / "linefoot", "draw", "stand", **elsewhere)
    assert said.split() == ["out/diagrams/stand.txt", "out/diagrams/stand.svg"]
    assert (elsewhere["cwd"] / "out/diagrams/stand.svg").stat().st_size > 1000
    assert files() == before
