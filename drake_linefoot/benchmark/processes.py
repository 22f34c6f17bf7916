"""What is measured in processes of their own: imports, start-up, memory."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from drake_linefoot.errors import LinefootError

LONGEST = 3600.0  # [s] that a process may take


def run_time(command: list[str]) -> float:
    """Return how long a process takes from its start to its end [s].

    Raises:
        LinefootError: it fails.
    """
    start = time.perf_counter()
    _run(command)
    return time.perf_counter() - start


def import_time(module: str) -> float:
    """Return how long a process takes that imports a module and ends [s]."""
    return run_time([sys.executable, "-c", f"import {module}"])


def help_time() -> float:
    """Return how long `linefoot --help` takes [s], by the installed command when there is one."""
    command = Path(sys.executable).with_name("linefoot")
    words = [str(command)] if command.exists() else [sys.executable, "-m", "drake_linefoot"]
    return run_time([*words, "--help"])


def first_step_time() -> float:
    """Return how long `linefoot walk` takes from its start to the end of its first step [s].

    The process is ended there: see `first_step`.
    """
    with tempfile.TemporaryDirectory(prefix="linefoot-") as folder:
        command = [sys.executable, "-m", "drake_linefoot.benchmark.first_step", f"{folder}/walk"]
        start = time.time()
        return float(_run(command)) - start


def memory_growth(first: float, last: float) -> dict[str, Any]:
    """Return what `memory` prints of a walk: resident memory at two times, less the log."""
    words = [sys.executable, "-m", "drake_linefoot.benchmark.memory", f"{first:g}", f"{last:g}"]
    found: dict[str, Any] = json.loads(_run(words))
    return found


def _run(command: list[str]) -> str:
    done = subprocess.run(
        command, capture_output=True, text=True, check=False, timeout=LONGEST, stdin=None
    )
    if done.returncode != 0:
        last = (done.stderr.strip().splitlines() or ["no message"])[-1]
        raise LinefootError(f"{' '.join(command[1:])} failed: {last}")
    return done.stdout.strip()
