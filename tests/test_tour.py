"""The notebook runs from its first cell to its last, and is kept without outputs."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
NOTEBOOK = ROOT / "examples" / "tour.ipynb"

# In a process of its own: kernels leave warnings behind that would fail other tests.
RUN = """
import sys, nbformat
from nbclient import NotebookClient
notebook = nbformat.read(sys.argv[1], 4)
NotebookClient(notebook, timeout=300).execute()
nbformat.write(notebook, "ran.ipynb")
"""


def cells(path):
    return [c for c in json.loads(path.read_text(encoding="utf-8"))["cells"] if "outputs" in c]


def test_outputs_are_not_kept():
    assert NOTEBOOK.stat().st_size < 30_000
    assert all(c["outputs"] == [] and c["execution_count"] is None for c in cells(NOTEBOOK))


@pytest.mark.slow
def test_notebook_runs(tmp_path):
    done = subprocess.run(
        [sys.executable, "-c", RUN, str(NOTEBOOK)],
        cwd=tmp_path,
        env={
            **os.environ,
            "PYTHONPATH": str(ROOT),
            "MPLBACKEND": "module://matplotlib_inline.backend_inline",
        },
        capture_output=True,
        text=True,
        check=False,
        timeout=400,
    )
    assert done.returncode == 0, done.stderr
    outputs = [output for cell in cells(tmp_path / "ran.ipynb") for output in cell["outputs"]]
    printed = "".join("".join(o["text"]) for o in outputs if o["output_type"] == "stream")
    assert "kSolutionFound" in printed and "largest use: " in printed
    assert printed.count("fell: False") == 2
    kinds = [kind for o in outputs if "data" in o for kind in o["data"]]
    assert kinds.count("image/png") == 4
    assert kinds.count("image/svg+xml") == 1
    (frame,) = [
        "".join(o["data"]["text/html"]) for o in outputs if "text/html" in o.get("data", {})
    ]
    assert 'src="out/tour/replay.html"' in frame
    assert (tmp_path / "out" / "tour" / "replay.html").stat().st_size > 1_000_000
