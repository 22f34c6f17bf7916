"""Run examples/tour.ipynb, and keep its outputs in it but for what differs from run to run.

`make notebook`, or for a copy, with the files that it writes:

    python tools/run_notebook.py tour.ipynb
    python tools/run_notebook.py first.ipynb examples/first_walk.ipynb
"""

from __future__ import annotations

import os
import re
import sys
import tempfile
from pathlib import Path

import nbformat
from nbclient import NotebookClient

ROOT = Path(__file__).resolve().parents[1]
NOTEBOOK = ROOT / "examples" / "tour.ipynb"
ADDRESS = re.compile(r" at 0x[0-9a-f]+")  # of an object in memory
LONGEST = 600  # [s] for a cell


def main(out: Path = NOTEBOOK, source: Path = NOTEBOOK) -> None:
    """Run a notebook in the folder of a copy, that of the repository in a scratch folder."""
    notebook = nbformat.read(source, 4)
    metadata = notebook.metadata.copy()  # the kernel would add its version
    os.environ["PYTHONPATH"] = str(ROOT)
    os.environ["MPLBACKEND"] = "module://matplotlib_inline.backend_inline"
    with tempfile.TemporaryDirectory() as scratch:
        place = {"metadata": {"path": scratch if out == NOTEBOOK else str(out.resolve().parent)}}
        NotebookClient(
            notebook, timeout=LONGEST, resources=place, record_timing=False, kernel_name="python3"
        ).execute()
    notebook.metadata = metadata
    for cell in notebook.cells:
        if cell.cell_type == "code":
            cell.metadata.pop("execution", None)
            cell.outputs = [o for o in cell.outputs if o.get("name") != "stderr"]
            for output in cell.outputs:
                if "text/plain" in output.get("data", {}):
                    output.data["text/plain"] = ADDRESS.sub("", output.data["text/plain"])
    nbformat.write(notebook, out)


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
