"""Sweeps that studies take draws of."""

from functools import cache
from pathlib import Path

from drake_linefoot.lab.sweep.file import Sweep, load_sweep


@cache
def sweep_of(file: Path) -> Sweep:
    """Return a sweep; a process reads it once, as the ends of all distributions are checked.

    Raises:
        ScenarioError: as `load_sweep`.
    """
    return load_sweep(file)
