"""`python -m studies.qpbenchmark`: the problem set, and what solvers make of it."""

import sys

from studies.common.command import run
from studies.qpbenchmark.problems import qpbenchmark

if __name__ == "__main__":
    sys.exit(run(qpbenchmark, "qpbenchmark"))
