"""The newcomer's notebook: ten cells, in which nothing goes wrong."""

import ast
import re
from importlib.metadata import PackageNotFoundError, distribution

import nbformat
import pytest

from tests.helpers.notebooks import ROOT, run_notebook

NOTEBOOK = ROOT / "examples" / "first_walk.ipynb"


def code(path):
    return [cell for cell in nbformat.read(path, 4).cells if cell.cell_type == "code"]


def test_it_has_ten_short_cells_and_keeps_no_outputs():
    cells = code(NOTEBOOK)
    assert len(cells) == 10
    for cell in cells:
        ast.parse(cell.source)
        assert len(cell.source.splitlines()) <= 30
        assert (cell.outputs, cell.execution_count) == ([], None)


@pytest.mark.slow
def test_it_runs_and_shows_what_it_says(tmp_path):
    """With three walks where it judges ten, which are the same but for their numbers."""
    few, ran = tmp_path / "few.ipynb", tmp_path / "first_walk.ipynb"
    text = NOTEBOOK.read_text(encoding="utf-8")
    assert text.count("range(10)") == 1
    few.write_text(text.replace("range(10)", "range(3)"), encoding="utf-8")
    run_notebook(ran, few, timeout=550)
    shown = [
        ["".join(o.get("text", "")) for o in cell.outputs if "text" in o]
        + [kind for o in cell.outputs for kind in o.get("data", {}) if kind != "text/plain"]
        for cell in code(ran)
    ]
    walk, look, plot, push, loop, block, task, ten, report, robot = shown
    assert (walk, look, plot, report) == (
        ["text/html"],
        ["text/html"],
        ["image/png"],
        ["text/html"],
    )
    assert push == ["upright\n", "image/png"] and block == ["image/png"]
    assert loop == ["image/svg+xml"]
    said, page = task
    assert page == "text/html" and float(re.search(r"moves (.*) rad", said)[1]) > 0.1
    assert ten == ["3 of 3 upright\n"]
    try:
        distribution("example-robot-data")
    except PackageNotFoundError:
        return
    assert re.fullmatch(r"the G1 walked 0\.[5-9] m\n", robot[0]) and robot[1] == "text/html"
