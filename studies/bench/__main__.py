"""`python -m studies.bench`: speed and memory, beside other packages."""

import sys

from studies.bench.bench import bench
from studies.common.command import run

if __name__ == "__main__":
    sys.exit(run(bench, "bench"))
