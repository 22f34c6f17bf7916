"""What a result was made with: rows of different code are never mixed."""

import hashlib
from functools import cache
from importlib.metadata import version as version_of
from pathlib import Path

from drake_linefoot import __version__
from drake_linefoot.resources import PACKAGE, models_dir


@cache
def made_with() -> dict[str, str]:
    """Return versions, and a short hash of the code and the models, of this process.

    It is that of the time of the first call, which is about when the code was imported.
    """
    return {
        "drake_linefoot": __version__,
        "drake": version_of("drake"),
        "numpy": version_of("numpy"),
        "numba": version_of("numba"),
        "code": code_digest(PACKAGE, models_dir()),
    }


def code_digest(package: Path, models: Path) -> str:
    """Return a short hash of the Python files of `package` and of all files of `models`."""
    content = hashlib.sha256()
    for folder, pattern in ((package, "*.py"), (models, "*")):
        for path in sorted(path for path in folder.rglob(pattern) if path.is_file()):
            content.update(path.relative_to(folder).as_posix().encode())
            content.update(path.read_bytes())
    return content.hexdigest()[:16]


def differences(ours: dict[str, str], theirs: dict[str, str]) -> str:
    """Return in words what differs; empty when nothing does."""
    names = dict.fromkeys([*ours, *theirs])
    return ", ".join(
        f"{name} {theirs.get(name)} instead of {ours.get(name)}"
        for name in names
        if ours.get(name) != theirs.get(name)
    )
