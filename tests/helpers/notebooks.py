"""Notebooks, run as `make notebook` runs them."""

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TOOL = ROOT / "tools" / "run_notebook.py"


def run_notebook(out, *notebook, timeout):
    """Run a notebook, the tour if none is given, into a file in whose folder it works [s].

    In a process of its own: kernels leave warnings behind.
    """
    done = subprocess.run(
        [sys.executable, str(TOOL), str(out), *map(str, notebook)],
        cwd=out.parent,
        env=os.environ,
        capture_output=True,
        text=True,
        check=False,
        timeout=timeout,
    )
    assert done.returncode == 0, done.stderr
