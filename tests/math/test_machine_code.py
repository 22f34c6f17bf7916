"""How compiled functions are kept on the disk: which are used again, damaged ones, old ones."""

import os
import shutil
import subprocess
import sys

import pytest
from numba.core.codegen import get_host_cpu_features

from drake_linefoot.math import machine_code
from drake_linefoot.math.compiled import PACKAGE
from drake_linefoot.math.machine_code import (
    SHIPPED_CPU,
    SHIPPED_FEATURES,
    complete,
    is_complete,
    shipped_in,
)

INNER = """from drake_linefoot.math.compiled import compiled
@compiled
def inner(x):
    return {}
"""
OUTER = """from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.inner import inner
@compiled
def outer(x):
    return inner(x) + 1.0
"""
ASK = """from drake_linefoot.math.outer import outer
print(outer(2.0), sum(outer.stats.cache_hits.values()))
"""
OF_ANOTHER_NUMBA = "import numba; numba.__version__ = '0.1'\n" + ASK
FOR_ANY = {"NUMBA_CPU_NAME": SHIPPED_CPU, "NUMBA_CPU_FEATURES": SHIPPED_FEATURES}


@pytest.fixture
def ask(tmp_path):
    """Run two kernels, one calling the other, in a copy of the package; by what the inner does."""
    copy = tmp_path / "drake_linefoot"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    (copy / "math" / "outer.py").write_text(OUTER)

    # Python takes its own bytecode for that of a source of the same size, changed within a second.
    fixed = {
        "PYTHONPATH": str(tmp_path),
        "NUMBA_DISABLE_JIT": "0",
        "PYTHONDONTWRITEBYTECODE": "1",
    }

    def answer(expression, code=ASK, **environment):
        (copy / "math" / "inner.py").write_text(INNER.format(expression))
        done = subprocess.run(
            [sys.executable, "-c", code],
            env=os.environ | fixed | environment,
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=True,
        )
        answer.said = done.stderr.splitlines()
        return done.stdout.split()

    return answer


def test_machine_code_is_kept_until_a_kernel_changes_that_it_calls(ask):
    assert ask("10.0 * x") == ["21.0", "0"]
    assert ask("10.0 * x") == ["21.0", "1"]
    assert ask("20.0 * x") == ["41.0", "0"]


def test_machine_code_goes_where_the_user_wants_it(ask, tmp_path):
    users = tmp_path / "mine"
    assert ask("3.0 * x", NUMBA_CACHE_DIR=str(users)) == ["7.0", "0"]
    assert len(list(users.glob("kernels-*/*/outer.outer-*.nbc"))) == 1
    assert not list((tmp_path / "drake_linefoot" / "__pycache__").glob("kernels-*"))


def test_in_a_folder_that_cannot_be_written_it_is_kept_for_the_same_sources_only(ask, tmp_path):
    (
        tmp_path / "drake_linefoot" / "__pycache__"
    ).touch()  # a file, which root cannot write to either
    home = tmp_path / "home"
    where = {"HOME": str(home), "XDG_CACHE_HOME": str(home / "cache")}
    assert ask("10.0 * x", **where) == ["21.0", "0"]
    assert ask("10.0 * x", **where) == ["21.0", "1"]
    assert ask("20.0 * x", **where) == ["41.0", "0"]
    assert len(list(home.rglob("kernels-*"))) == 2
    assert not list((tmp_path / "drake_linefoot").rglob("*.nb?"))


def test_without_any_folder_it_lasts_as_long_as_the_process(ask, tmp_path):
    (tmp_path / "mine").touch()
    where = {"NUMBA_CACHE_DIR": str(tmp_path / "mine")}
    assert ask("10.0 * x", **where) == ask("10.0 * x", **where) == ["21.0", "0"]


def truncate(file):
    file.write_bytes(file.read_bytes()[:-40])


def flip(file):
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 4
    file.write_bytes(content)


def replace_by_a_folder(file):
    file.unlink()
    file.mkdir()


DAMAGE = {"empty": lambda file: file.write_bytes(b""), "cut": truncate, "flipped": flip}


@pytest.mark.parametrize("damage", DAMAGE)
@pytest.mark.parametrize("kind", ["nbi", "nbc"])
def test_damaged_machine_code_is_made_anew_and_said_in_a_line(ask, tmp_path, kind, damage):
    assert ask("10.0 * x") == ["21.0", "0"]
    files = list(tmp_path.rglob(f"*.{kind}"))
    assert len(files) == 2
    for file in files:
        DAMAGE[damage](file)
    assert ask("10.0 * x") == ["21.0", "0"]
    (line,) = ask.said
    assert line.startswith("machine code on the disk is damaged and made anew: ")
    assert ask("10.0 * x") == ["21.0", "1"]
    assert ask.said == []


def test_machine_code_that_cannot_be_read_or_written_stops_nothing(ask, tmp_path):
    assert ask("10.0 * x") == ["21.0", "0"]
    for file in tmp_path.rglob("*.nb?"):
        replace_by_a_folder(file)
    assert ask("10.0 * x") == ["21.0", "0"]
    read, written = ask.said
    assert "Is a directory" in read
    assert written.startswith("machine code cannot be kept: ")


def test_folders_of_old_sources_are_removed_but_for_the_last_few(ask, tmp_path):
    folder = tmp_path / "drake_linefoot" / "__pycache__"
    folder.mkdir()
    for i in range(6):
        old = folder / f"kernels-{i}"
        (old / "math").mkdir(parents=True)
        os.utime(old, (1e9 + i, 1e9 + i))
    (folder / "other").mkdir()
    assert ask("10.0 * x") == ["21.0", "0"]
    left = sorted(path.name for path in folder.iterdir() if path.is_dir())
    assert [name for name in left if len(name) < 20] == [
        "kernels-3",
        "kernels-4",
        "kernels-5",
        "other",
    ]
    assert len(left) == 5


# --- machine code that a wheel brought -----------------------------------------------------


@pytest.fixture
def shipped(ask, tmp_path):
    """Machine code of the two kernels for any processor, where a wheel puts it; its folder."""
    assert ask("10.0 * x", NUMBA_CACHE_DIR=str(tmp_path / "made"), **FOR_ANY) == ["21.0", "0"]
    (made,) = (tmp_path / "made").glob("kernels-*")
    return made.rename(tmp_path / "drake_linefoot" / made.name)


on_shipped_cpu = pytest.mark.skipif(
    not set(SHIPPED_FEATURES.split(",")) <= set(get_host_cpu_features().split(",")),
    reason="this processor is not an x86-64-v3",
)


def files_of(folder):
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@on_shipped_cpu
def test_shipped_machine_code_runs_in_a_package_that_has_moved(ask, shipped, tmp_path):
    """It is found by the content of the sources; times and places of files do not matter."""
    before = files_of(shipped)
    for file in (tmp_path / "drake_linefoot").rglob("*.py"):
        os.utime(file, (1e9, 1e9))
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "drake_linefoot").rename(tmp_path / "elsewhere" / "drake_linefoot")
    ask_there = {"PYTHONPATH": str(tmp_path / "elsewhere")}
    done = subprocess.run(
        [sys.executable, "-c", ASK],
        env=os.environ | ask_there | {"NUMBA_DISABLE_JIT": "0"},
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.split() == ["21.0", "1"]
    moved = tmp_path / "elsewhere" / "drake_linefoot" / shipped.name
    assert sorted(files_of(moved).values()) == sorted(before.values())
    assert not list((tmp_path / "elsewhere" / "drake_linefoot" / "__pycache__").rglob("*.nb?"))


@on_shipped_cpu
def test_shipped_machine_code_is_read_where_nothing_can_be_written(ask, shipped, tmp_path):
    (tmp_path / "drake_linefoot" / "__pycache__").touch()
    (tmp_path / "home").touch()
    nowhere = {"HOME": str(tmp_path / "home"), "XDG_CACHE_HOME": str(tmp_path / "home" / "cache")}
    assert ask("10.0 * x", **nowhere) == ["21.0", "1"]
    assert ask("20.0 * x", **nowhere) == ["41.0", "0"]  # of other sources


@on_shipped_cpu
@pytest.mark.parametrize("why", ["another processor", "another Numba", "another source"])
def test_where_shipped_machine_code_does_not_fit_it_is_compiled_as_without(ask, shipped, why):
    before = files_of(shipped)
    asked = {
        "another processor": {"NUMBA_CPU_NAME": "generic"},
        "another Numba": {"code": OF_ANOTHER_NUMBA},
        "another source": {},
    }[why]
    expression, answer = ("20.0 * x", "41.0") if why == "another source" else ("10.0 * x", "21.0")
    assert ask(expression, **asked) == [answer, "0"]
    assert ask(expression, **asked) == [answer, "1"]
    assert files_of(shipped) == before


@on_shipped_cpu
@pytest.mark.parametrize("kind", ["nbi", "nbc"])
def test_damaged_shipped_machine_code_is_made_anew_and_kept_elsewhere(ask, shipped, kind):
    for file in shipped.rglob(f"*.{kind}"):
        flip(file)
    before = files_of(shipped)
    assert ask("10.0 * x") == ["21.0", "0"]
    (line,) = ask.said
    assert line.startswith("machine code on the disk is damaged and made anew: ")
    assert ask("10.0 * x") == ["21.0", "1"]
    assert ask.said == []
    assert files_of(shipped) == before


@pytest.mark.parametrize("missing", ["avx2", "fma", None])
def test_a_processor_takes_it_that_has_every_feature(monkeypatch, tmp_path, missing):
    has = f"+adx,{SHIPPED_FEATURES},-avx512f".replace(f"+{missing},", f"-{missing},")
    monkeypatch.setattr(machine_code, "get_host_cpu_features", lambda: has)
    folder = tmp_path / "kernels-1"
    folder.mkdir()
    assert shipped_in(tmp_path, "1", None, None) == (None if missing else folder)
    assert shipped_in(tmp_path, "2", None, None) is None
    assert shipped_in(tmp_path, "1", "generic", "") is None


def test_what_is_complete_is_so_for_one_python_and_numba(monkeypatch, tmp_path):
    assert not is_complete(None)
    assert not is_complete(tmp_path)
    complete(tmp_path)
    assert is_complete(tmp_path)
    monkeypatch.setattr(machine_code.numba, "__version__", "0.1")
    assert not is_complete(tmp_path)
