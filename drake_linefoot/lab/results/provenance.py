"""What a result was made with: rows of different code are never mixed.

Code is named by short hashes of its files, and not by a commit: what is installed in place keeps
the version that it had then.
"""

import hashlib
from collections.abc import Iterable
from functools import cache
from importlib.metadata import version as version_of
from pathlib import Path

from drake_linefoot import __version__
from drake_linefoot.resources import PACKAGE, models_dir

LAB = "lab"  # folder of what simulates, judges and shows
CONTROLLER = "controller"


@cache
def made_with() -> dict[str, str]:
    """Return versions, and digests of the code, of this process.

    `controller` is of the package but for its lab, and of the models; `lab` of the lab. They are of
    the time of the first call, which is about when the code was imported.
    """
    lab = PACKAGE / LAB
    models = [path for path in models_dir().rglob("*") if path.is_file()]
    controller = [path for path in PACKAGE.rglob("*.py") if lab not in path.parents]
    return {
        "drake_linefoot": __version__.partition(".dev")[0],
        "drake": version_of("drake"),
        "numpy": version_of("numpy"),
        "numba": version_of("numba"),
        CONTROLLER: digest({PACKAGE: controller, models_dir(): models}),
        LAB: digest({lab: lab.rglob("*.py")}),
    }


def digest(files: dict[Path, Iterable[Path]]) -> str:
    """Return a short hash of files, of their content and their names in the folder they are of."""
    content = hashlib.sha256()
    for folder, some in files.items():
        for path in sorted(some):
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
