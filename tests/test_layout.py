"""The layout holds: imports go inwards only, files and functions stay short.

Ring 0 is numpy, scipy and Numba, ring 1 may use Drake's multibody, maths and solvers, ring 2 are
the LeafSystems, ring 3 puts them together. What is read here is the source, so an import
inside a function counts as well. One under `if TYPE_CHECKING:` counts too, but for one rule:
ring 1 may name the Context of a plant in its signatures.
"""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "drake_linefoot"
MAX_FILE_LINES = 300
MAX_FUNCTION_LINES = 60

RING_0 = (
    "math/",
    "contact/cone_kernels.py",
    "contact/wrench_cone.py",
    "gait/schedule.py",
    "gait/footstep_kernels.py",
    "gait/ground_kernels.py",
    "gait/pendulum.py",
    "gait/pendulum_kernels.py",
    "gait/reference_kernels.py",
    "gait/swing.py",
    "gait/swing_kernels.py",
    "gait/target_kernels.py",
    "errors.py",
    "signals.py",
)
RING_2 = (
    "systems.py",
    "contact/contact_estimator.py",
    "gait/gait_planner.py",
    "gait/centroidal_reference.py",
    "mpc/ecd_mpc.py",
    "wbc/whole_body_controller.py",
)
RING_3 = (
    "benchmark/",
    "drive/",
    "evaluation/",
    "results/",
    "robustness/",
    "simulation/",
    "sweep/",
    "visualization/",
    "wiring/",
    "cli.py",
    "__main__.py",
)
BOXES = ("math/", "robot/", "contact/", "gait/", "mpc/", "wbc/")

FILES = sorted(path.relative_to(PACKAGE).as_posix() for path in PACKAGE.rglob("*.py"))


def is_in(name, ring):
    """Whether the file `name` is one of `ring`: files, and folders ending in a slash."""
    return any(name == entry or (entry[-1] == "/" and name.startswith(entry)) for entry in ring)


def in_ring(ring):
    return pytest.mark.parametrize("name", [name for name in FILES if is_in(name, ring)])


def tree_of(name):
    return ast.parse((PACKAGE / name).read_text(encoding="utf-8"), filename=name)


def imported(tree, name):
    """Return the dotted names that the source of the file `name` imports.

    `from a import b` gives `a.b`, for b may be a module.
    """
    here = ("drake_linefoot", *Path(name).parent.parts)
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            outer = here[: len(here) - node.level + 1] if node.level else ()
            source = ".".join([*outer, *filter(None, [node.module])])
            found.update(f"{source}.{alias.name}" for alias in node.names)
    return found


def without_type_checking(tree):
    """Return the tree less the bodies of its `if TYPE_CHECKING:`, which never run."""
    for node in ast.walk(tree):
        if isinstance(node, ast.If) and ast.unparse(node.test).endswith("TYPE_CHECKING"):
            node.body = []
    return tree


def is_under(module, package):
    return module == package or module.startswith(package + ".")


def file_of(module):
    """Return the file of the package's `module` (or of the module that has that name)."""
    parts = module.split(".")[1:]
    for end in (len(parts), len(parts) - 1):
        path = "/".join(parts[:end])
        for candidate in (f"{path}.py", f"{path}/__init__.py" if path else "__init__.py"):
            if (PACKAGE / candidate).is_file():
                return candidate
    return "/".join(parts)


def wrong_for_ring_0(module):
    if is_under(module, "drake_linefoot"):
        return not is_in(file_of(module), (*RING_0, "__init__.py"))
    top = module.split(".")[0]
    return top not in sys.stdlib_module_names and top not in {"numba", "numpy", "scipy"}


@in_ring(RING_0)
def test_ring_0_imports_numpy_scipy_and_numba_only(name):
    assert {m for m in imported(tree_of(name), name) if wrong_for_ring_0(m)} == set()


def test_ring_0_runs_without_drake():
    """The `__init__` of a folder must not pull Drake in behind the back of its modules."""
    names = [name for name in FILES if is_in(name, RING_0) and not name.endswith("__init__.py")]
    modules = ["drake_linefoot." + name.removesuffix(".py").replace("/", ".") for name in names]
    code = f"import sys, {', '.join(modules)}; sys.exit('pydrake' in sys.modules)"
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, timeout=60, check=True)


@pytest.mark.parametrize("name", [n for n in FILES if not is_in(n, (*RING_2, *RING_3))])
def test_only_leaf_systems_and_ring_3_import_systems(name):
    """`pydrake.all` counts: it has the systems in it."""
    systems = ("pydrake.systems", "pydrake.all")
    modules = imported(without_type_checking(tree_of(name)), name)
    assert {m for m in modules if any(is_under(m, s) for s in systems)} == set()


@in_ring(BOXES)
def test_boxes_of_the_loop_do_not_import_ring_3(name):
    own = {m for m in imported(tree_of(name), name) if is_under(m, "drake_linefoot")}
    assert {m for m in own if is_in(file_of(m), RING_3)} == set()


@pytest.mark.parametrize(
    "name", [n for n in FILES if not is_in(n, ("evaluation/", "robustness/", "cli.py"))]
)
def test_only_the_command_line_imports_the_evaluation(name):
    modules = imported(tree_of(name), name)
    assert {m for m in modules if is_under(m, "drake_linefoot.evaluation")} == set()


@pytest.mark.parametrize("name", [n for n in FILES if not is_in(n, ("benchmark/", "cli.py"))])
def test_only_the_command_line_imports_the_benchmark(name):
    modules = imported(tree_of(name), name)
    assert {m for m in modules if is_under(m, "drake_linefoot.benchmark")} == set()


@pytest.mark.parametrize(
    "name", [n for n in FILES if not is_in(n, ("sweep/", "robustness/", "cli_sweep.py"))]
)
def test_only_the_command_line_imports_the_sweep(name):
    modules = imported(tree_of(name), name)
    assert {m for m in modules if is_under(m, "drake_linefoot.sweep")} == set()


@pytest.mark.parametrize("name", FILES)
def test_nothing_imports_all_of_drake(name):
    assert "pydrake.all.*" not in imported(tree_of(name), name)


@pytest.mark.parametrize("name", FILES)
def test_files_and_functions_are_short(name):
    lines = (PACKAGE / name).read_text(encoding="utf-8").count("\n")
    assert lines <= MAX_FILE_LINES
    long = {
        node.name: node.end_lineno - node.lineno + 1
        for node in ast.walk(tree_of(name))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
        and node.end_lineno - node.lineno + 1 > MAX_FUNCTION_LINES
    }
    assert long == {}


def test_type_checking_imports_can_be_left_out():
    source = "if TYPE_CHECKING:\n    import pydrake.systems\nelse:\n    import pydrake.math"
    tree = without_type_checking(ast.parse(source))
    assert imported(tree, "robot/dynamics.py") == {"pydrake.math"}


@pytest.mark.parametrize(
    ("source", "modules"),
    [
        ("import pydrake.systems.framework as f", {"pydrake.systems.framework"}),
        ("from pydrake.all import *", {"pydrake.all.*"}),
        ("from pydrake import systems", {"pydrake.systems"}),
        ("def f():\n    from ..cli import main", {"drake_linefoot.cli.main"}),
        ("from . import swing", {"drake_linefoot.gait.swing"}),
        ("from ..wiring import walk", {"drake_linefoot.wiring.walk"}),
    ],
)
def test_imports_are_read_in_every_spelling(source, modules):
    assert imported(ast.parse(source), "gait/schedule.py") == modules
