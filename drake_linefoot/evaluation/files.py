"""Folders and files of reports: checked before the work, written in one go after it."""

from __future__ import annotations

import os
from pathlib import Path

from drake_linefoot.errors import OutputError


def prepare(out: Path) -> None:
    """Make the folder, and see that files can be written there.

    Raises:
        OutputError: they cannot.
    """
    probe = out / ".probe"
    try:
        out.mkdir(parents=True, exist_ok=True)
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise OutputError(out, error.strerror or str(error)) from error


def write_text(path: Path, text: str) -> None:
    """Write a file in one go: what was there stays until the new one is complete."""
    scratch = path.with_name(f".{path.name}.new")
    scratch.write_text(text, encoding="utf-8")
    os.replace(scratch, path)
