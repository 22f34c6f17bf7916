"""Files of reports: their folder is checked before the work, each is written in one go after it."""

import json
from io import BytesIO
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from drake_linefoot.files import write_file, writing

DOTS_PER_INCH = 90


def prepare(out: Path) -> None:
    """Make the folder, and see that files can be written there.

    Raises:
        OutputError: they cannot.
    """
    probe = out / ".probe"
    with writing(out):
        out.mkdir(parents=True, exist_ok=True)
        probe.touch()
        probe.unlink()


def write_text(path: Path, text: str) -> None:
    """Write a text: what was there stays until the new file is complete.

    Raises:
        OutputError: it cannot be written; so do the functions below.
    """
    write_file(path, text.encode())


def write_json(path: Path, data: Any, indent: int | None = 2) -> None:
    """Write data as JSON; a number that is not finite is a mistake."""
    write_text(path, json.dumps(data, indent=indent, allow_nan=False) + "\n")


def write_picture(path: Path, figure: Figure) -> None:
    """Write a figure as PNG."""
    content = BytesIO()
    figure.savefig(content, format="png", dpi=DOTS_PER_INCH)
    write_file(path, content.getvalue())
