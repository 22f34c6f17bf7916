"""`python -m studies.estimation`: walking on the estimate, and what it costs."""

import sys

from studies.common.command import run
from studies.estimation.estimation import estimation

if __name__ == "__main__":
    sys.exit(run(estimation, "estimation"))
