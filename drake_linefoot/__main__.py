"""`python -m drake_linefoot` is the command `linefoot`."""

import sys

from drake_linefoot.cli import main

if __name__ == "__main__":
    sys.exit(main())
