"""What a benchmark ran on."""

import os
import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from drake_linefoot import __version__

PACKAGES = ("drake", "mujoco", "numpy", "scipy", "daqp", "piqp", "proxsuite", "quadprog")


def version_of(package: str) -> str | None:
    """Return the version of an installed distribution; None without it."""
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def processor() -> str:
    """Return the name of the processor."""
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def machine() -> dict[str, Any]:
    """Return processor, cores, system, and how busy it is (load of the last minute)."""
    return {
        "processor": processor(),
        "cores": os.cpu_count(),
        "system": f"{platform.system()} {platform.release().split('-')[0]} {platform.machine()}",
        "load": round(os.getloadavg()[0], 2),
    }


def versions() -> dict[str, str | None]:
    """Return the versions of Python, this package and everything that is measured."""
    found = {package: version_of(package) for package in PACKAGES}
    return {"python": platform.python_version(), "drake_linefoot": __version__, **found}
