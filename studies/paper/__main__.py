"""`python -m studies.paper`: the paper's figures, or one of them."""

import sys

from studies.common.command import run
from studies.paper.paper import paper

if __name__ == "__main__":
    sys.exit(run(paper, "paper"))
