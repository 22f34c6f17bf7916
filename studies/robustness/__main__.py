"""`python -m studies.robustness`: the sweeps, held against their thresholds."""

import sys

from studies.common.command import run
from studies.robustness.main import robustness

if __name__ == "__main__":
    sys.exit(run(robustness, "robustness"))
