"""The command `linefoot`, and `python -m drake_linefoot`."""

import sys
from importlib.util import find_spec

from drake_linefoot.errors import MissingPackageError


def main() -> int:
    """Run the command; say what to install where the laboratory that it belongs to is not."""
    if find_spec("typer") is None:
        print(MissingPackageError("linefoot", "typer"), file=sys.stderr)
        return 2
    from drake_linefoot.lab.cli import main as command

    return command()


if __name__ == "__main__":
    sys.exit(main())
