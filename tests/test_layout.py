"""The layout holds: imports go one way, without circles; files and functions stay short.

The package has one order, `ORDER`: a module imports what stands before it. Beside that, modules
`WITHOUT_DRAKE` run on numpy, scipy, Numba and pydantic, and of the boxes of the controller only the
LeafSystems import `pydrake.systems`. What is read here is the source, so an import inside a
function counts as well. One under `if TYPE_CHECKING:` counts too, but for one rule: a formula may
name the Context of a plant in its signature.
"""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

from drake_linefoot.late import late

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "drake_linefoot"
MAX_FILE_LINES = 300
MAX_FUNCTION_LINES = 60
MAX_ARGUMENTS = 8

# Files and folders of the package; each imports only what stands before it. A folder is what of it
# is in no longer entry.
ORDER = (
    "_environment.py",
    "errors.py",
    "late.py",
    "__init__.py",
    "types.py",
    "constants.py",
    "facts.py",
    "fields.py",
    "checks.py",
    "parameters.py",
    "files.py",
    "page.py",
    "yaml_file.py",
    "resources.py",
    "math/",
    "axes.py",
    "statuses.py",
    "layout.py",
    "parts.py",
    "signals.py",
    "terrain.py",
    "centroidal.py",
    "leaf_system.py",
    "tunable_block.py",
    "contact/",
    "robot/",
    "estimation/",
    "gait/",
    "mpc/ecd.py",
    "mpc/models/",
    "mpc/",
    "wbc/",
    "wiring/",
    "lab/__init__.py",
    "lab/new_robot/",
    "lab/scenario/",
    "lab/plants/",
    "lab/simulation/",
    "lab/visualization/",
    "lab/wiring/",
    "lab/remote/",
    "lab/walk.py",
    "lab/gym/",
    "lab/results/",
    "lab/pool.py",
    "lab/sweep/",
    "lab/drive/",
    "lab/cli/",
    "__main__.py",
)
BOXES = ("math/", "robot/", "contact/", "estimation/", "gait/", "mpc/", "wbc/")
LEAF_SYSTEMS = (
    "leaf_system.py",
    "tunable_block.py",
    "robot/state_dynamics.py",
    "estimation/contact_estimator.py",
    "estimation/state_estimator.py",
    "gait/gait_planner.py",
    "mpc/centroidal_reference.py",
    "mpc/ecd_mpc.py",
    "mpc/late_plan.py",
    "mpc/process_mpc.py",
    "wbc/whole_body_controller.py",
)
LIBRARIES = {"annotated_types", "numba", "numpy", "pydantic", "pydantic_core", "scipy"}
WITHOUT_DRAKE = (
    "math/",
    "axes.py",
    "centroidal.py",
    "checks.py",
    "constants.py",
    "errors.py",
    "fields.py",
    "files.py",
    "layout.py",
    "parameters.py",
    "parts.py",
    "resources.py",
    "signals.py",
    "statuses.py",
    "terrain.py",
    "types.py",
    "contact/contacts.py",
    "contact/solvers.py",
    "contact/wrench_cone.py",
    "estimation/filter_state.py",
    "estimation/invariant_filter.py",
    "gait/clock.py",
    "gait/contacts.py",
    "gait/command.py",
    "gait/crossing.py",
    "gait/footing.py",
    "gait/footholds.py",
    "gait/footsteps.py",
    "gait/ground.py",
    "gait/horizon.py",
    "gait/known_ground.py",
    "gait/learning.py",
    "gait/measurement.py",
    "gait/next_stance.py",
    "gait/outlook.py",
    "gait/patches.py",
    "gait/parameters.py",
    "gait/pendulum.py",
    "gait/planner.py",
    "gait/recovery.py",
    "gait/running.py",
    "gait/schedule.py",
    "gait/standing.py",
    "gait/state.py",
    "gait/step_bound.py",
    "gait/step_program.py",
    "gait/step_times.py",
    "gait/swing.py",
    "gait/swing_foot.py",
    "gait/told_ground.py",
    "gait/touchdown.py",
    "gait/viability.py",
    "mpc/ecd.py",
    "robot/tree.py",
    "wbc/priorities.py",
)

FILES = sorted(path.relative_to(PACKAGE).as_posix() for path in PACKAGE.rglob("*.py"))
STUDIES = sorted(path.relative_to(ROOT).as_posix() for path in ROOT.glob("studies/**/*.py"))


def is_in(name, places):
    """Whether the file `name` is one of `places`: files, and folders ending in a slash."""
    return any(name == entry or (entry[-1] == "/" and name.startswith(entry)) for entry in places)


def each_in(places):
    return pytest.mark.parametrize("name", [name for name in FILES if is_in(name, places)])


def tree_of(name, root=PACKAGE):
    return ast.parse((root / name).read_text(encoding="utf-8"), filename=name)


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


def place_of(name):
    """Return the longest entry of `ORDER` that a file belongs to; itself where there is none."""
    return max((place for place in ORDER if is_in(name, [place])), key=len, default=name)


def imports_of(name):
    """Return the files of the package that a file imports from, but for itself."""
    own = {m for m in imported(tree_of(name), name) if is_under(m, "drake_linefoot")}
    return {file_of(m) for m in own} - {name}


def circles(graph):
    """Return the strongly connected components of more than one node, each sorted.

    Args:
        graph: the nodes that each node leads to.
    """

    def reached(node):
        seen, left = set(), [node]
        while left:
            for following in graph[left.pop()] - seen:
                seen.add(following)
                left.append(following)
        return seen

    reach = {node: reached(node) for node in graph}
    found = {
        tuple(sorted(other for other in reach[node] if node in reach[other]))
        for node in graph
        if node in reach[node]
    }
    return {circle for circle in found if len(circle) > 1}


def test_every_file_and_folder_has_its_place_in_the_order():
    assert {place_of(name) for name in FILES} == set(ORDER)


@pytest.mark.parametrize("name", FILES)
def test_imports_go_one_way(name):
    at = ORDER.index(place_of(name))
    assert {m for m in imports_of(name) if ORDER.index(place_of(m)) > at} == set()


def test_no_circle_of_files():
    """The file that a name comes from counts, not the `__init__.py` of the folders above it."""
    assert circles({name: imports_of(name) for name in FILES}) == set()


def test_no_circle_of_folders():
    graph = {place: set() for place in ORDER}
    for name in FILES:
        graph[place_of(name)] |= {place_of(m) for m in imports_of(name)} - {place_of(name)}
    assert circles(graph) == set()


def test_circles_are_found():
    graph = {"a": {"b"}, "b": {"c"}, "c": {"b", "d"}, "d": set(), "e": {"a", "e"}}
    assert circles(graph) == {("b", "c")}


def test_names_of_later_modules_are_there():
    calls = [
        tuple(ast.literal_eval(word) for word in node.args)
        for name in FILES
        for node in ast.walk(tree_of(name))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "late"
    ]
    assert len(calls) == 7
    for home, name in calls:
        assert callable(late(home, name))


def wrong_without_drake(module):
    if is_under(module, "drake_linefoot"):
        return not is_in(file_of(module), (*WITHOUT_DRAKE, "__init__.py"))
    top = module.split(".")[0]
    return top not in sys.stdlib_module_names and top not in LIBRARIES


@each_in(WITHOUT_DRAKE)
def test_modules_without_drake_import_nothing_else(name):
    assert {m for m in imported(tree_of(name), name) if wrong_without_drake(m)} == set()


def test_modules_without_drake_run_without_it():
    """The `__init__` of a folder must not pull Drake in behind the back of its modules."""
    names = [n for n in FILES if is_in(n, WITHOUT_DRAKE) and not n.endswith("__init__.py")]
    modules = ["drake_linefoot." + name.removesuffix(".py").replace("/", ".") for name in names]
    code = f"import sys, {', '.join(modules)}; sys.exit('pydrake' in sys.modules)"
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, timeout=60, check=True)


@pytest.mark.parametrize(
    "name",
    [
        name
        for name in FILES
        if not is_in(name, LEAF_SYSTEMS)
        and (is_in(name, (*BOXES, "lab/scenario/")) or "/" not in name)
    ],
)
def test_only_leaf_systems_of_the_controller_import_systems(name):
    """`pydrake.all` counts: it has the systems in it."""
    systems = ("pydrake.systems", "pydrake.all")
    modules = imported(without_type_checking(tree_of(name)), name)
    assert {m for m in modules if any(is_under(m, s) for s in systems)} == set()


@pytest.mark.parametrize("name", FILES)
def test_the_package_does_not_know_the_studies(name):
    assert {m for m in imported(tree_of(name), name) if is_under(m, "studies")} == set()


@pytest.mark.parametrize("name", STUDIES)
def test_studies_use_the_package_and_not_its_command_line(name):
    modules = imported(tree_of(name, ROOT), name)
    assert {m for m in modules if m.startswith(("drake_linefoot.lab.cli", "tests"))} == set()


@pytest.mark.parametrize(
    "name", [n for n in FILES if not is_in(n, ("lab/sweep/", "lab/cli/sweep.py"))]
)
def test_only_the_command_line_imports_the_sweep(name):
    modules = imported(tree_of(name), name)
    assert {m for m in modules if is_under(m, "drake_linefoot.lab.sweep")} == set()


@pytest.mark.parametrize("name", FILES)
def test_nothing_imports_all_of_drake(name):
    assert "pydrake.all.*" not in imported(tree_of(name), name)


@pytest.mark.parametrize("name", [*(f"drake_linefoot/{name}" for name in FILES), *STUDIES])
def test_files_and_functions_are_short(name):
    lines = (ROOT / name).read_text(encoding="utf-8").count("\n")
    assert lines <= MAX_FILE_LINES
    long = {
        node.name: node.end_lineno - node.lineno + 1
        for node in ast.walk(tree_of(name, ROOT))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
        and node.end_lineno - node.lineno + 1 > MAX_FUNCTION_LINES
    }
    assert long == {}


def test_no_module_is_named_after_its_technique():
    assert [name for name in (*FILES, *STUDIES) if "kernel" in name] == []


@pytest.mark.parametrize("name", [*(f"drake_linefoot/{name}" for name in FILES), *STUDIES])
def test_functions_have_few_arguments(name):
    """`self` and `cls` are not counted."""
    many = {}
    for node in ast.walk(tree_of(name, ROOT)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda):
            a = node.args
            every = [*a.posonlyargs, *a.args, *a.kwonlyargs]
            names = [each.arg for each in every if each.arg not in {"self", "cls"}]
            if len(names) > MAX_ARGUMENTS:
                many[getattr(node, "name", "lambda")] = names
    assert many == {}


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
        ("def f():\n    from ..lab.cli import main", {"drake_linefoot.lab.cli.main"}),
        ("from . import swing", {"drake_linefoot.gait.swing"}),
        ("from ..wiring import walk", {"drake_linefoot.wiring.walk"}),
    ],
)
def test_imports_are_read_in_every_spelling(source, modules):
    assert imported(ast.parse(source), "gait/schedule.py") == modules
