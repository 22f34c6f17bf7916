"""`python -m studies.envelope`: the fastest commands that are walked."""

import sys

from studies.common.command import run
from studies.envelope.envelope import envelope

if __name__ == "__main__":
    sys.exit(run(envelope, "envelope"))
