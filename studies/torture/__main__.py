"""`python -m studies.torture`: try to break it, and count."""

import sys

from studies.common.command import run
from studies.torture.torture import torture

if __name__ == "__main__":
    sys.exit(run(torture, "torture"))
