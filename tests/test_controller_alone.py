"""The controller needs what pyproject.toml names as dependencies, and nothing of the laboratory.

An environment of its own has the wheel, and links to exactly these distributions of this one, with
what they need themselves. There examples/06_own_diagram.py walks.
"""

import os
import re
import sysconfig
from importlib import metadata
from pathlib import Path

import pytest
import trimesh
from packaging.requirements import Requirement

from drake_linefoot.math.compiled import machine_code_folder
from tests.test_packaging import RELEASING, ROOT, run, wheel

built = wheel  # a fixture

EXAMPLE = ROOT / "examples" / "06_own_diagram.py"
LAB = (
    *("typer", "rich", "jinja2", "tornado", "matplotlib", "plotly", "distributed", "trimesh"),
    *("collada", "pyarrow", "mcap", "psutil", "msgpack", "cryptography", "pygraphviz"),
    "foxglove_schemas_protobuf",
)
# Drake's wheel names it for tools of its own, which the controller does not call.
LEFT_OUT = {"matplotlib"}


def needed_by(requirements):
    """Return the distributions that requirements without an extra lead to, by name."""
    found, left = {}, list(requirements)
    while left:
        requirement = Requirement(left.pop())
        name = requirement.name.lower().replace("_", "-")
        wanted = requirement.marker is None or requirement.marker.evaluate({"extra": ""})
        if wanted and name not in found and name not in LEFT_OUT:
            found[name] = metadata.distribution(requirement.name)
            left += found[name].requires or []
    return found


@pytest.fixture(scope="module")
def alone(built, tmp_path_factory):
    """Return the Python of an environment with the wheel and its base dependencies."""
    python = RELEASING["environment_with"](built, tmp_path_factory.mktemp("alone") / "venv")
    home = {"base": str(python.parents[1]), "platbase": str(python.parents[1])}
    site = Path(sysconfig.get_path("purelib", vars=home))
    (site / "lent.pth").unlink()  # it lends every distribution
    (own,) = metadata.distributions(name="drake_linefoot", path=[str(site)])
    for distribution in needed_by(own.requires).values():
        tops = {file.parts[0] for file in distribution.files} - {"..", "__pycache__"}
        for top in tops:
            place = Path(distribution.locate_file(top))
            if not (site / top).exists():
                (site / top).symlink_to(place)
    return python


@pytest.fixture
def elsewhere(tmp_path):
    """Keywords of a process in an empty folder, with this machine code and nothing else of ours."""
    kept = {"NUMBA_CACHE_DIR": str(machine_code_folder().parent)}
    own = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    return {"cwd": tmp_path, "env": own | kept, "timeout": 600}


@pytest.mark.slow
def test_nothing_of_the_laboratory_is_there(alone, elsewhere):
    code = (
        "from importlib.util import find_spec; import drake_linefoot\n"
        f"print(drake_linefoot.__file__, [name for name in {LAB} if find_spec(name)])"
    )
    file, found = run(alone, "-c", code, **elsewhere).split(maxsplit=1)
    assert Path(file).is_relative_to(alone.parents[1])
    assert found.strip() == "[]"


@pytest.mark.slow
def test_the_controller_walks_in_a_diagram_of_the_users_own(alone, elsewhere):
    said = run(alone, EXAMPLE, "--seconds", "2", **elsewhere)
    forward, left, height = map(float, re.search(r"torso at \[(.+?)\] m", said)[1].split())
    assert 0.3 < forward < 0.6  # 0.4 m/s, but for the first step
    assert abs(left) < 0.1
    assert 0.6 < height < 0.75


@pytest.mark.slow
def test_a_name_and_the_command_of_the_laboratory_say_what_to_install(alone, elsewhere):
    code = (
        "try:\n    from drake_linefoot import walk\nexcept ImportError as error:\n    print(error)"
    )
    extra = "pip install 'drake_linefoot[lab]'\n"
    assert run(alone, "-c", code, **elsewhere).endswith(extra)
    code = "import sys; from drake_linefoot.__main__ import main; sys.stderr = sys.stdout; main()"
    assert run(alone, "-c", code, **elsewhere).endswith(extra)


@pytest.mark.slow
def test_drawings_of_stl_meshes_name_what_reads_them(alone, elsewhere, tmp_path):
    shape = trimesh.creation.box((0.1, 0.1, 0.1))
    shape.export(tmp_path / "box.stl")
    robot = ROOT / "models" / "mit_humanoid"
    text = (robot / "mit_humanoid.urdf").read_text(encoding="utf-8")
    text = re.sub(r'filename="[^"]+"', 'filename="box.stl"', text)
    (tmp_path / "mit_humanoid.urdf").write_text(text, encoding="utf-8")
    (tmp_path / "stl.yaml").write_text((robot / "mit_humanoid.yaml").read_text(encoding="utf-8"))
    code = (
        "from drake_linefoot import load_humanoid\n"
        "from pydrake.multibody.plant import AddMultibodyPlantSceneGraph\n"
        "from pydrake.systems.framework import DiagramBuilder\n"
        "robot = load_humanoid('stl.yaml')\n"
        "def plant(): return AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.001)[0]\n"
        "robot.add_to(plant(), drawn=False)\n"
        "try: robot.add_to(plant())\nexcept ImportError as error: print(error)"
    )
    said = "reading the mesh box.stl needs trimesh, which is not installed"
    assert run(alone, "-c", code, **elsewhere).startswith(said)
