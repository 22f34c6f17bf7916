"""`python -m studies.zoo`: which robots walk with nothing typed, and how fast."""

import sys

from studies.common.command import run
from studies.zoo.zoo import zoo

if __name__ == "__main__":
    sys.exit(run(zoo, "zoo"))
