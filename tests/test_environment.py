"""BLAS runs on one thread, whichever way the process was started."""

import json
import os
import subprocess
import sys

import pytest

from drake_linefoot import _environment

# The package's own setting in this process must not be what the child inherits.
CLEAN = {name: value for name, value in os.environ.items() if name not in _environment.VARIABLES}

# macOS has no affinity to ask for.
CORES = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()

LOAD_EVERY_BLAS = """
import json, threadpoolctl
import numpy, scipy.linalg, pydrake.multibody.plant
pools = threadpoolctl.threadpool_info()
print(json.dumps([[p["filepath"], p["num_threads"]] for p in pools if p["user_api"] == "blas"]))
"""


def blas_threads(start):
    """Run `start` in a fresh process, load every BLAS, return (library, threads) pairs."""
    done = subprocess.run(
        [sys.executable, "-c", start + LOAD_EVERY_BLAS],
        env=CLEAN,
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    return json.loads(done.stdout)


@pytest.mark.parametrize(
    "start",
    [
        "import drake_linefoot",
        "import drake_linefoot.errors",
        "import numpy; import drake_linefoot",
        "import numpy, scipy.linalg; import drake_linefoot",
        "import pydrake.multibody.plant; import drake_linefoot",
    ],
)
def test_every_blas_has_one_thread(start):
    pools = blas_threads(start)
    assert pools, "no BLAS found: this test sees nothing"
    assert {library: count for library, count in pools if count != 1} == {}


@pytest.mark.skipif(CORES == 1, reason="one core gives one thread")
def test_without_the_package_there_would_be_more():
    assert max(count for _, count in blas_threads("")) > 1


def test_a_number_chosen_by_the_user_is_kept(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "3")
    _environment.limit_blas_threads()
    assert os.environ["OMP_NUM_THREADS"] == "3"
