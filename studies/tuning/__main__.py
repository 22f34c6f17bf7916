"""`python -m studies.tuning`: a search for weights of the MPC."""

import sys

from studies.common.command import run
from studies.tuning.tuning import tuning

if __name__ == "__main__":
    sys.exit(run(tuning, "tuning"))
